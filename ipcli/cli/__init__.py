"""One file a command: parse the options, call the stage, print the result."""
