"""Cases, finite element models, reduction and the stage that the march starts from."""
