"""The pages of brdf-train and brdf-model."""
