"""The digital twin in the plane and at sea; posture test, dive."""
