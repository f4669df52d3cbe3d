"""Open digital twin and control stack for soft robotic fish."""

from hypertuna.description import Robot as Robot
from hypertuna.description import load as load
from hypertuna.errors import InputError as InputError
from hypertuna.gait import Gait as Gait
from hypertuna.sweep import Gaits as Gaits
from hypertuna.sweep import gradient as gradient
from hypertuna.sweep import sweep as sweep
from hypertuna.swim import Swim as Swim
from hypertuna.swim import swim as swim
