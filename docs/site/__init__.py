"""The documentation site: `python -m docs.site out/site` builds it."""
