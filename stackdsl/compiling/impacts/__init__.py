"""What hits, pushes, pulls out or slides in: from what an author writes to where and when it begins."""
