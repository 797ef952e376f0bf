"""Pages of depth fusion, a module an artefact kind."""
