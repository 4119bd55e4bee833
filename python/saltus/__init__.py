"""What the program saltus calls to draw the tables that a run left."""
