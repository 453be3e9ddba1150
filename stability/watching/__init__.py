"""What both methods need of a world that is stepped: who is at rest, who is held, and who is about to be hit."""
