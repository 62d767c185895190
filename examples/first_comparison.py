"""First comparison: by how much friction feedforward improves the tracking of a joint."""

from adaptive_ff import compare, load_scenario

scenario = load_scenario().modified(  # the built-in joint, but ...
    duration=20.0,
    sampling={"period": 0.001},  # ... controlled at 1 kHz,
    change=[{"time": 10.0, "friction_scale": 0.6}],  # and friction drops by 40 % on the way
    controllers=["pi", "oracle", "adaptive"],
)
comparison = compare(scenario)
for name, gain in comparison.improvement.items():
    print(f"{name:10s} settled error of pi over its own: {gain:.2f}")
print("estimates at the end:", comparison.runs["adaptive"].final_estimates)
comparison.plot("results/first_comparison")
