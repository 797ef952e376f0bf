"""What readers make and models take: views, clips of motion, part images, and their names; each with its own check."""
