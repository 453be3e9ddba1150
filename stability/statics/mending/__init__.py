"""What is to be changed so that bricks stand that fall, each answer tried by a verdict."""
