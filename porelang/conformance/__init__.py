"""Conformance: that NumPy in float64 and float32 and GLSL compute one and the same geometry, within a proven bound.

`suite.run_suite` sweeps the table of operations, runs the conformance programs and judges random graphs;
`report` is `pore doctor` and `pore conformance`. What the law is, and how to read a certificate: docs/conformance.md.
"""
