"""What a packing keeps of its performance when its spheres scatter in size and rub on each other."""
