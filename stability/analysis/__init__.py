"""What is proven beyond a verdict: margins, orders of building, repairs, uniqueness of rest."""
