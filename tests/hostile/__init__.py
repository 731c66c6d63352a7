"""The hostile trial: wrong and odd inputs by the hundred, each with the answer that a user should get."""
