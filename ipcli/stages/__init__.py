"""One module a command: read artefacts, call models on arrays, write artefacts. No mathematics here."""
