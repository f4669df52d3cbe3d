"""Soft joints by finite elements; needs the extra `fe`.

geometry (the drawing), mesh, energies, newton (equilibrium), model (a joint), measure (its measurements), bend (rising
pressure), section (a joint without ends), states, comparison and joint_map (both beside the fast model), fields,
pictures, plots, cards, extra (optional packages).
"""
