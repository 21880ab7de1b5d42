"""What several rooms need: Laplacians, rigid fits, closest points, volumetric ARAP."""
