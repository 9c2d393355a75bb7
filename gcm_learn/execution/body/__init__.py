"""The arm in MuJoCo (extra ``sim``): mass, torque and contact."""
