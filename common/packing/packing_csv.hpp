#pragma once
// A packing from CSV. Discs: columns x, y, radius (m), optionally id, vx, vy (m/s), wz (1/s); a comment line gives the cell
// whose columns are the periodic vectors, "# cell_h00=0.15 cell_h01=0 cell_h10=0 cell_h11=0.15", and optionally thickness=
// (m) and rho= (kg/m^3).
// Contacts (optional): columns id1, id2, nx, ny (unit normal from 1 to 2), overlap (m), ftx, fty (N, force on id2), optionally
// fn (N, > 0 in compression). The periodic image of id2 follows from the normal and the overlap.
#include <string>

#include "common/packing/packing.hpp"

namespace talik {

Packing read_packing_csv(const std::string& particles, const std::string& contacts = "");

} // namespace talik
