"""What reports show of the paper beside flights."""

from skylimb.analysis.recording.publication import Publication
from skylimb.studies.reproduction.claims_check import check_claims
from skylimb.studies.reproduction.paper_configuration import not_the_papers
from skylimb.studies.reproduction.paper_numbers import SOURCE, published_beside

PAPER = Publication(SOURCE, published_beside, check_claims, not_the_papers)
