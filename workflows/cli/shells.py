"""Shells that tab completion can be switched on in."""

from __future__ import annotations

SHELLS = ("bash", "zsh", "fish")
#: Lines that switch completion on, by shell, and the file that they belong into.
SWITCH_ON = {
    "bash": ('eval "$(granwave completion bash)"', "~/.bashrc"),
    "zsh": ('eval "$(granwave completion zsh)"', "~/.zshrc, after compinit"),
    "fish": ("granwave completion fish | source", "~/.config/fish/config.fish"),
}
