"""How canwire's texts are kept plain: words that no text uses, and random samples for a reader."""
