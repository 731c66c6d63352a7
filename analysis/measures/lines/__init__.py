"""Lines of grains: front speed, decay in two regions, width, lateral force, and where crystals part."""
