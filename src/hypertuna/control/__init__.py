"""Constants of the controller and pilot on board, computed from the description; the algorithms are in the core.

`sensors`: sensor models and faults. `controller`: constants of the controller. `mission`: waypoints, limits and water.
`guidance`: constants of the pilot, its gait table and mission.
"""
