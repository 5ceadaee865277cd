#pragma once
// The part of a scene that speaks of heat: plain data in SI units, temperatures in degrees C.
#include <optional>
#include <string>
#include <vector>

#include "common/math/matrix.hpp"

namespace talik::driver {

// Soil as grains, water, ice and air. Fractions refer to the initial volume.
struct ThermalMaterialSpec {
    std::string name;
    double porosity = 0.0;          // n, -
    double saturation = 1.0;        // of the pores with water and ice, -; the rest is air
    double grain_density = 2650.0, water_density = 1000.0, ice_density = 1000.0;            // kg/m^3
    double grain_heat_capacity = -1.0, water_heat_capacity = 4180.0, ice_heat_capacity = 2100.0; // J/(kg K)
    double grain_conductivity = -1.0, water_conductivity = 0.56, ice_conductivity = 2.24, air_conductivity = 0.025; // W/(m K)
    double latent_heat = 333e3;     // L, J/kg
    std::string conductivity_mean = "geometric";   // Eq. (2), or "arithmetic", "harmonic"
    std::string conductivity_file;                 // CSV temperature_C, conductivity_W_per_mK: in place of the mixture
    Eigen::Vector3d anisotropy = {1.0, 1.0, 0.0};  // xx yy xy: the conductivity tensor is k times this
    bool turns = false;                            // the tensor's axes turn with the material
    std::string frozen_water = "conserves mass";   // or "fills pores": as many litres of ice as of water
    std::string curve = "ramp";                    // "ramp", "fine", "saturation", "table", "none"
    double freezing_temperature = 0.0;             // T0, degrees C
    double residual_temperature = 0.0;             // T_res of the ramp, degrees C
    double residual_saturation = 0.0;              // S_res: of ramp and saturation curve, -
    double width = 0.5;                            // W of the saturation curve, K
    std::optional<double> water_content;           // w0 of the fine soil, mass of water over mass of grains, -
    double residual_water_content = 0.058;         // wbar, -
    double decay = 0.16;                           // a, 1/K
    std::string curve_file;                        // CSV temperature_C, unfrozen_saturation
};

// A value in time: constant, plus a sine, or a table.
struct TimeValueSpec {
    std::optional<double> constant;
    double amplitude = 0.0;   // of constant + amplitude sin(2 pi (t - shift) / period)
    double period = 0.0;      // s; 0 = no sine
    double shift = 0.0;       // s
    std::string file;         // CSV time_s, value; equal times make a jump
};

// One side of the material, as seen from outside along an axis; it follows the material when that moves.
struct HeatBoundarySpec {
    std::string name, side;                   // "left", "right", "bottom", "top"
    std::string kind = "temperature";         // or "flux"
    TimeValueSpec value;                      // degrees C, or W/m^2 into the material
    std::optional<double> from, to;           // m, along the side; all of it where absent
};

// Ground held at a temperature: a box, or a line between two points.
struct HeaterSpec {
    std::string name;
    std::vector<Vector> box, line;            // two corners, two ends, m
    TimeValueSpec value;                      // degrees C
    std::optional<double> begins, ends;       // s, of the scene's clock, as its stages
};

struct HeatSourceSpec {
    std::string name, body;                   // of a body, or of everything where empty
    std::vector<Vector> box;                  // only where the points were inside at the start
    TimeValueSpec value;                      // W/m^3 of present volume
    std::string shape_file;                   // CSV x_m, y_m, factor on a regular grid: multiplies the value
};

struct HeatSpec {
    std::string formulation = "enthalpy";     // or "capacity": the paper's, with the heat capacity of A2
    double stability = 4.0;                   // b of Eq. (43)
    double ice_step = 0.01;                   // with mechanics: largest change of ice saturation per step of heat, -
    double time_scale = 1.0;                  // seconds of heat per second of the scene
    std::vector<ThermalMaterialSpec> materials;
    std::vector<HeatBoundarySpec> boundaries;
    std::vector<HeaterSpec> heaters;
    std::vector<HeatSourceSpec> sources;
};

} // namespace talik::driver
