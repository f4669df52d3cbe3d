"""What runs on board, computed from the description: controller, sensors, guidance, mission."""
