// Zero, as a uniform that is never set: a factor that the driver cannot see. Drivers fold x * 0.0 to 0.0 in spite of
// `precise`, also where x is infinite or no number (seen on Mesa 22.3).
uniform float pore_nought;
