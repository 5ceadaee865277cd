#pragma once
// The list of candidate contacts, with a skin: who could touch before the discs have moved, or the cell has stretched, by
// more than a bound. Canonical order (first, second, image), so that the same state gives the same list and bits.
#include "rve-farm/assembly/answer.hpp"
#include "rve-farm/assembly/columns.hpp"

namespace talik::farm {

enum class Search { automatic, linked_cells, brute_force };

// How far any disc may still move, non-affinely, before a pair outside the list could touch, m; negative: not at all. With
// strains bounded by e since the list was built and each disc displaced by at most u, a pair that was r_i + r_j + skin apart
// is still exp(-e) (r_i + r_j + skin) - 2 u apart. `strain`: bound of what is to come besides.
double displacement_left(const AssemblyNumbers& numbers, double strain);

// Chooses the skin where it may, reduces the basis, wraps the discs into the cell, finds the candidates and carries over what the contacts remember:
// tangential forces, bonds. Bonded pairs are kept however far apart. Answers contact_list_full, or not_finite where
// a disc is nowhere near the cell: the RVE is then to be restored from a saved state.
// Scratch memory belongs to the thread, and grows to the largest assembly it has seen.
Status rebuild_neighbours(AssemblyView& s, const ColumnChoice& columns, Search search = Search::automatic);

// owned_begin: the contacts whose `first` is a disc, which are contiguous.
void index_owned(AssemblyView& s);

} // namespace talik::farm
