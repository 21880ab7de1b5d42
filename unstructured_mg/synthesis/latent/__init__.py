"""A latent space of one connectivity's shapes (R section 3): principal components, or a variational autoencoder."""
