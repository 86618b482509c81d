"""Parameters of a controller, tuned for a vehicle: error against steering effort."""

from popsteer.lab.tune import report
from popsteer.lab.tune.problem import Problem, Score, usual_search
from popsteer.lab.tune.study import Trial, Tuned, run

__all__ = ["Problem", "Score", "Trial", "Tuned", "report", "run", "usual_search"]
