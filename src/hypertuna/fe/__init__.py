"""Soft joints by finite elements; needs the extra `fe`.

<<<<<<< HEAD
<<<<<<< HEAD
geometry (the drawing), mesh, energies, mixed (the pressure as an unknown), newton (equilibrium), model (a joint),
measure (its state), bend (rising pressure), section (a joint without ends), comparison and
joint_map (with the fast model), fields, pictures, plots, extra (optional packages).
=======
geometry (the drawing), mesh, energies, newton (equilibrium), model (a joint), measure (its state), bend (rising
pressure), section (a joint without ends), comparison (with the analytic model), potential and reduction (the twin's
table), fields, pictures, plots, extra (optional packages).
>>>>>>> hub/main
=======
geometry (the drawing), mesh, energies, newton (equilibrium), model (a joint), measure (its state), bend (rising
pressure), section (a joint without ends), comparison and joint_map (with the fast model), fields, pictures, plots,
extra (optional packages).
>>>>>>> 17757301009108bf2ade17dec385ccc12a57d9bd
"""
