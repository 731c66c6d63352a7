"""What a packing keeps from the target below it: force, impulse and energy that arrive, by bottom and by height."""
