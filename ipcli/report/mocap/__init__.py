"""Pages of action recognition, a module an artefact kind."""
