// Form factors that are known: what those by rays are held against.
#pragma once

namespace gicube::samples {

// Two unit squares face to face, one side apart, in a medium of `kappa` a side: the closed form if it is clear (Howell, A
// Catalog of Radiation Heat Transfer Configuration Factors, C-11), or else by quadrature to 1e-9.
double parallel_squares(double kappa);

// Two unit squares at a right angle with a common edge (C-14).
double perpendicular_squares();

// The mean of 1 / r^2 over two unit cubes whose centres are `distance` >= 2 sides apart along an edge, by quadrature to 1e-9.
double mean_inverse_square(double distance);

}  // namespace gicube::samples
