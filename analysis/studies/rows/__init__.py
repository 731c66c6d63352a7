"""Studies of rows and packings with other grains beside their spheres."""
