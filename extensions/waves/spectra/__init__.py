"""Small waves about a static state: bands of infinite, periodic packings, modes and transmission
of finite packings.
"""
