"""What an author may write: values, layouts, claims, and the whole scenario."""
