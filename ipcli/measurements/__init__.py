"""What readers make and models take: views, clips of motion, and their names; each with a check of its own."""
