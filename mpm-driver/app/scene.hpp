#pragma once
// A scene as the driver's code sees it: SI units, checked. Read from TOML by mpm-driver/app/scene_schema.cpp, whose one
// table of keys validates, prints help and makes docs/scene.md.
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/math/matrix.hpp"
#include "common/packing/packing_spec.hpp"
#include "mpm-driver/app/heat_scene.hpp"

namespace talik::driver {

// The background grid: square cells; walls may stand anywhere in it.
struct DomainSpec {
    Vector origin = Vector::Zero(); // m
    Vector size = Vector::Zero();   // m
    double cell = 0.0;              // h, m
    double thickness = 1.0;         // out of plane, m
    std::string volume_strain = "point"; // of a point: its own, or "cell": the mean over the points of its cell
};

// A body is a box or a polygon, filled with points.
struct BodySpec {
    std::string name;
    std::vector<Vector> polygon; // m; a box is read as its four corners
    std::string law;             // "rve", "elastic", or "none": at rest, for scenes of heat alone
    int points_per_cell = 4;     // 1, 4, 9, 16: the same number along each axis
    std::optional<double> density; // bulk density kg/m^3; else from the RVE's discs (law "rve")
    Vector velocity = Vector::Zero(); // initial, m/s
    Eigen::Vector3d stress = Eigen::Vector3d::Zero(); // initial sxx syy sxy of law "elastic", Pa
    std::string material;        // of heat, by name
    std::optional<double> temperature; // at the start, degrees C
    std::string temperature_file;      // or from a CSV x_m, y_m, temperature_C on a regular grid
    bool frozen = false;         // where it starts at T0 of a sharp front: frozen
};

struct ElasticSpec {
    double young = 0.0;   // Pa, plane strain
    double poisson = 0.0; // -
};

// A rigid, flat wall along a coordinate axis. It bounds the material from one side and may move and stand between nodes.
struct WallSpec {
    std::string name;
    std::string side;            // "left", "right", "bottom", "top": which side of the material it bounds
    double position = 0.0;       // m, of its face at the start
    std::string kind = "roller"; // "roller": no normal motion through it; "fixed": sticks in all directions
    double friction = 0.0;       // Coulomb friction of a roller, -
    bool separates = false;      // true: the material may lift off; false: it is held on both sides
    double velocity = 0.0;       // m/s along the axis (signed), in stages that list it in `moves`
    double ramp = 0.0;           // s: the velocity grows smoothly from 0 over this time once the wall starts to move
};

// One stage of a run.
struct StageSpec {
    std::string name;
    double duration = 0.0;                // s, at most
    std::optional<double> energy_ratio;   // ends earlier, once kinetic energy / internal work of the stage stays below this
    Vector gravity = Vector::Zero();      // m/s^2
    double gravity_ramp = 0.0;            // s: gravity grows smoothly to it from that of the stage before (from 0 at the start)
    double particle_damping = 0.0;        // alpha_p, 1/s (Eq. 34)
    double grid_damping = 0.0;            // alpha_g, 1/s (Eq. 34)
    double pic = 0.0;                     // alpha_PIC per step, in [0, 1] (Eq. 34)
    std::vector<std::string> moves;       // walls that move in this stage
    std::vector<std::string> activates;   // at its start: "bonds"
    std::vector<std::string> activates_in; // names of bodies; empty = in all
};

// Swelling of ground whose pore water freezes.
struct PhaseChangeStrainSpec {
    double expansion = 0.09; // of water on freezing, relative, -
};

struct StepSpec {
    std::optional<double> fixed; // s; empty = "auto"
    double safety = 0.5;         // fraction of the limit (42) taken by "auto"
};

struct OutputSpec {
    double history_interval = 0.0;    // s; 0 = every step
    double fields_interval = 0.0;     // s; 0 = start and end only
    double checkpoint_interval = 0.0; // s; 0 = at the end only
};

struct Scene {
    std::string title;
    std::uint64_t seed = 1;
    DomainSpec domain;
    std::vector<BodySpec> bodies;
    std::optional<ElasticSpec> elastic;
    std::optional<RveSpec> rve;
    std::optional<HeatSpec> heat;
    std::optional<PhaseChangeStrainSpec> phase_change_strain;
    std::vector<WallSpec> walls;
    double confining_pressure = 0.0; // Pa on all free sides, compression positive; follows the material exactly
    StepSpec step;
    std::vector<StageSpec> stages;
    OutputSpec output;

    std::string file; // as given
    std::string hash; // of the checked content and of the files it names, so that comments and layout do not count

    // Bodies move and carry stress; in a scene of heat alone (law "none" throughout) no column of mechanics exists.
    bool mechanics() const {
        for (const BodySpec& body : bodies)
            if (body.law != "none") return true;
        return bodies.empty();
    }
};

} // namespace talik::driver
