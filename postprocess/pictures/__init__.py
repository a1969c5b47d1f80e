"""Pictures of stages, runs and modes: stills, sheets of stills, films and web pages."""
