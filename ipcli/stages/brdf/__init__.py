"""The commands brdf-train and brdf-model."""
