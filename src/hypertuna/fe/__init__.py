"""Soft joints by finite elements; needs the extra `fe`.

geometry (the drawing), mesh, energies, newton (equilibrium), model (a joint), measure (its state), bend (rising
pressure), section (a joint without ends), states, comparison and joint_map (with the fast model), fields, pictures,
plots, cards, extra (optional packages).
"""
