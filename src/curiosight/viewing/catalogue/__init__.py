"""How a catalogue is browsed: one page of cards, and a map of what lies where."""

from curiosight.viewing.catalogue.page import CatalogueReport, catalogue_html, write_catalogue

__all__ = ["CatalogueReport", "catalogue_html", "write_catalogue"]
