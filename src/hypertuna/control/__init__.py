"""Numbers for what runs on board, computed from the description; what runs is core control/ and pilot/.

`sensors`: sensor models and faults. `controller`: constants of the controller. `mission`: where to go, in which water.
`guidance`: constants of the pilot, its gait table and mission.
"""
