#pragma once
// The tables of a scene that describe RVEs: [rve], [rve.packing], [rve.contact], [rve.bond]. Scenes of the driver and
// specifications of `rve-farm pack` and `element` share them.
#include "common/packing/packing_spec.hpp"
#include "common/scene/schema.hpp"

namespace talik::scene {

Table<RveSpec> rve_table();

// Paths inside a document are meant relative to the document; `faults` gains those of files that do not exist.
void resolve_packing_files(PackingSpec& packing, const std::string& document_file, const Place& rve);

// The part of a specification that shapes a packing (no bonds, no files), as TOML for `rve-farm pack`, and its fingerprint:
// the name of a prepared packing in a cache.
std::string packing_specification(const RveSpec& rve);
std::string packing_fingerprint(const RveSpec& rve);

} // namespace talik::scene
