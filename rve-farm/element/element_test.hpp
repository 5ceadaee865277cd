#pragma once
// Element tests: RVEs driven along a path without any macro solver, one or many side by side.
#include <functional>
#include <string>
#include <vector>

#include "common/packing/packing.hpp"
#include "common/physics/rve_parameters.hpp"
#include "rve-farm/backend/farm.hpp"

namespace talik::farm {

struct ElementTest {
    std::string path;                // "isotropic", "biaxial", "isochoric", "simple_shear"
    double rate = 0.1;               // 1/s: of compression along y (isotropic: along both axes), or of gamma_xy
    double strain = 0.15;            // at the end, logarithmic (simple shear: gamma)
    double pressure = 1e5;           // Pa, compression positive: held laterally in the biaxial test; of `settle`
    bool constant_height = true;     // simple shear: constant height, or constant vertical pressure
    double step = 5e-4;              // macro step, s
    int rows = 200;                  // of the curves
    bool forget_shear_forces = false; // before loading: tangential forces to zero
    bool settle = false;             // before loading: all stresses servoed to the pressure, until at rest
    bool activate_bonds = false;     // before loading: bonds at all contacts
    double ice_saturation = 1.0;     // S_i, constant
};

// One row of a curve. Strains are logarithmic and tension positive, as everything inside; the files turn them.
struct ElementRow {
    long step = 0;
    double time = 0.0;                                     // s
    double strain_xx = 0.0, strain_yy = 0.0, gamma = 0.0;  // ln(L/L0); gamma_xy = 2 eps_xy integrated
    Answer answer;
};
using ElementCurve = std::vector<ElementRow>; // first row: before loading

// One curve for each packing. options: threads and kernel. progress: fraction done and the strain reached.
std::vector<ElementCurve> run_element_test(const ElementTest& test, const RveParameters& parameters, const std::vector<Packing>& packings,
                                           const FarmOptions& options = {}, const std::function<void(double)>& progress = {});

} // namespace talik::farm
