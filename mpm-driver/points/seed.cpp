#include "mpm-driver/points/seed.hpp"

#include <cmath>

#include "common/base/error.hpp"

namespace talik::driver {
namespace {

int points_per_axis(const BodySpec& body) {
    const int n = static_cast<int>(std::lround(std::sqrt(body.points_per_cell)));
    require(n >= 1 && n <= 4 && n * n == body.points_per_cell,
            "body '" + body.name + "': points_per_cell is " + std::to_string(body.points_per_cell), "use 1, 4, 9 or 16");
    return n;
}

Vector lower_corner(const BodySpec& body) {
    Vector corner = body.polygon.front();
    for (const Vector& v : body.polygon) corner = corner.cwiseMin(v);
    return corner;
}

Vector upper_corner(const BodySpec& body) {
    Vector corner = body.polygon.front();
    for (const Vector& v : body.polygon) corner = corner.cwiseMax(v);
    return corner;
}

bool is_box(const BodySpec& body) {
    const Vector low = lower_corner(body), high = upper_corner(body);
    bool corners_only = body.polygon.size() == 4;
    for (const Vector& v : body.polygon)
        for (int axis = 0; axis < Dim; ++axis) corners_only = corners_only && (v[axis] == low[axis] || v[axis] == high[axis]);
    return corners_only;
}

// Even-odd rule on half-open edges, so that a centre on the common edge of two bodies belongs to one of them.
bool contains(const BodySpec& body, const Vector& x) {
    bool inside = false;
    for (std::size_t i = 0, j = body.polygon.size() - 1; i < body.polygon.size(); j = i++) {
        const Vector &a = body.polygon[i], &b = body.polygon[j];
        if ((a[1] > x[1]) != (b[1] > x[1]) && x[0] < a[0] + (b[0] - a[0]) * (x[1] - a[1]) / (b[1] - a[1])) inside = !inside;
    }
    return inside;
}

// Shows visit(x) the centres of the body's points within the box from low to high, row by row, until it returns false.
template <class Visit>
void visit_centres(const BodySpec& body, const Vector& origin, double cell, const Vector& low, const Vector& high, Visit&& visit) {
    const double spacing = 2.0 * point_half_size(body, cell);
    const Vector anchor = is_box(body) ? lower_corner(body) : origin;
    const Vector first = ((low - anchor) / spacing).array().floor(), last = ((high - anchor) / spacing).array().ceil();
    for (int j = static_cast<int>(first[1]); j < static_cast<int>(last[1]); ++j)
        for (int i = static_cast<int>(first[0]); i < static_cast<int>(last[0]); ++i) {
            const Vector x = anchor + spacing * Vector(i + 0.5, j + 0.5);
            if (contains(body, x) && !visit(x)) return;
        }
}

// Further inside than the rounding of corners and centres.
bool contains_well(const BodySpec& body, const Vector& x, double margin) {
    for (const Vector& shift : {Vector(margin, 0.0), Vector(-margin, 0.0), Vector(0.0, margin), Vector(0.0, -margin)})
        if (!contains(body, x + shift)) return false;
    return true;
}

void append_point(Points& points, const BodySpec& body, int body_index, const Vector& x, double volume) {
    const std::size_t p = points.count();
    points.resize(p + 1);
    points.body[p] = body_index;
    points.initial_position[p] = points.position[p] = x;
    if (points.mechanical) points.velocity[p] = body.velocity;
    points.initial_volume[p] = points.volume[p] = volume;
    points.mass[p] = *body.density * volume; // kg/m^3 * m^3
}

} // namespace

double point_half_size(const BodySpec& body, double cell) { return 0.5 * cell / points_per_axis(body); }

Points seed_points(const std::vector<BodySpec>& bodies, const Grid& grid, bool mechanical) {
    Points points;
    points.mechanical = mechanical;
    for (std::size_t b = 0; b < bodies.size(); ++b) {
        const BodySpec& body = bodies[b];
        require(body.polygon.size() >= 3, "body '" + body.name + "' has fewer than three corners", "give a box or a polygon");
        require(body.density && *body.density > 0.0, "body '" + body.name + "' has no density", "give its bulk density");
        const double spacing = 2.0 * point_half_size(body, grid.cell());
        const double volume = spacing * spacing * grid.thickness(); // m^3
        const std::size_t before = points.count();
        visit_centres(body, grid.domain_min(), grid.cell(), lower_corner(body), upper_corner(body), [&](const Vector& x) {
            append_point(points, body, static_cast<int>(b), x, volume);
            return true;
        });
        require(points.count() > before, "body '" + body.name + "' holds no point", "use a smaller cell or a larger body");
    }
    for (std::size_t p = 0; p < points.count(); ++p)
        require(grid.inside_domain(points.position[p]),
                "a point of body '" + bodies[points.body[p]].name + "' lies outside the domain", "enlarge the domain");
    return points;
}

bool holds_a_point(const BodySpec& body, const DomainSpec& domain) {
    bool any = false;
    visit_centres(body, domain.origin, domain.cell, lower_corner(body), upper_corner(body), [&](const Vector&) { return !(any = true); });
    return any;
}

double area_of_points(const BodySpec& body, const DomainSpec& domain) {
    const double spacing = 2.0 * point_half_size(body, domain.cell);
    double count = 0.0;
    visit_centres(body, domain.origin, domain.cell, lower_corner(body), upper_corner(body), [&](const Vector&) { return (count += 1.0) > 0.0; });
    return count * spacing * spacing;
}

bool overlap(const BodySpec& a, const BodySpec& b, const DomainSpec& domain) {
    const double margin = 1e-6 * domain.cell; // rounding of the input
    const Vector low = lower_corner(a).cwiseMax(lower_corner(b)), high = upper_corner(a).cwiseMin(upper_corner(b));
    if (((high - low).array() <= margin).any()) return false;
    if (is_box(a) && is_box(b)) return true;
    bool any = false;
    const auto look = [&](const BodySpec& of, const BodySpec& in) {
        visit_centres(of, domain.origin, domain.cell, low, high, [&](const Vector& x) { return !(any = any || contains_well(in, x, margin)); });
    };
    look(a, b);
    look(b, a);
    return any;
}

} // namespace talik::driver
