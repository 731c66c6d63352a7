"""Small waves about a static state: bands of endless packings, modes and transmission of finite
ones.
"""
