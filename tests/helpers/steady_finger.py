"""What leaves of the bench what is linearised."""

SLIDING = {
    "motion.tremor_um": 0.0,
    "motion.tremor_n": 0.0,
    "motion.load_drift": 0.0,
    "motion.stroke_mm": 2000.0,
    "touch.load.length_mm": 3000.0,
    "motion.start": 0.02,
    "friction.roughness_rms": 0.0,
    "friction.occlusion_ratio": 1.0,
    "friction.moist_loss": 0.0,
    "friction.load_exponent": 0.0,
}
"""A finger that slides steadily."""
SILENT = {"sensor.noise_density_n_rthz": 0.0, "sensor.adc_bits": 32, "touch.position.noise_um": 0.0}
"""A force sensor without noise or steps, and a speed without noise."""
