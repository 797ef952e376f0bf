"""What all stages share: when to make an artefact and how to publish it, work in progress, pages of artefacts."""
