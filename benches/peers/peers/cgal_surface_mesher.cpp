// CGAL's surface mesher (Delaunay refinement): the largest distance of facets is the parameter, relative to the diagonal of
// the box; angles are at least 30 degrees, as its manual advises.

#include "served.hpp"

#include <CGAL/Complex_2_in_triangulation_3.h>
#include <CGAL/IO/facets_in_complex_2_to_triangle_mesh.h>
#include <CGAL/Implicit_surface_3.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_default_triangulation_3.h>
#include <CGAL/make_surface_mesh.h>

#include <cmath>
#include <memory>

extern "C" double peer_value(std::uint32_t surface, double x, double y, double z);

namespace {

using Triangulation = CGAL::Surface_mesh_default_triangulation_3;
using Complex = CGAL::Complex_2_in_triangulation_3<Triangulation>;
using Traits = Triangulation::Geom_traits;
using Point = Traits::Point_3;

constexpr const char* NAMES[] = {"torus", "dodeca", "dtorus", "mcmullen", "chair", "decocube"};
// Largest circle around a facet, as a share of the diagonal: parts as thin as the surfaces' are seen.
constexpr double RADIUS = 0.03;
// Points are found to this share of the diagonal, well below the errors that are measured.
constexpr double PRECISION = 1e-8;
// Points a side of the grid on which an inner point is looked for.
constexpr int SEARCHED = 24;

struct Field {
    std::uint32_t number;
    double operator()(const Point& p) const { return peer_value(number, p.x(), p.y(), p.z()); }
};

struct Result {
    Triangulation triangulation;
    Complex complex{triangulation};
};

// The lowest of some points in the box: CGAL wants a sphere around a point inside.
Point inner_point(const Field& f, const std::array<double, 6>& box) {
    Point best(0, 0, 0);
    double least = f(best);
    const auto at = [&](int axis, int i) {
        return box[2 * axis] + (box[2 * axis + 1] - box[2 * axis]) * (i + 0.5) / SEARCHED;
    };
    for (int i = 0; i < SEARCHED; ++i)
        for (int j = 0; j < SEARCHED; ++j)
            for (int k = 0; k < SEARCHED; ++k) {
                const Point p(at(0, i), at(1, j), at(2, k));
                if (const double value = f(p); value < least) least = value, best = p;
            }
    return best;
}

std::unique_ptr<Result> solve(const Request& request) {
    std::uint32_t number = 0;
    while (number < 5 && request.name != NAMES[number]) ++number;
    const Field field{number};
    const Point center = inner_point(field, request.box);
    double diagonal = 0, farthest = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double low = request.box[2 * axis], high = request.box[2 * axis + 1];
        diagonal += (high - low) * (high - low);
        farthest += std::pow(std::max(high - center[axis], center[axis] - low), 2);
    }
    diagonal = std::sqrt(diagonal);
    const Traits::Sphere_3 sphere(center, farthest);
    const CGAL::Implicit_surface_3<Traits, Field> surface(field, sphere, PRECISION);
    const CGAL::Surface_mesh_default_criteria_3<Triangulation> criteria(
        30.0, RADIUS * diagonal, request.parameter * diagonal);
    auto result = std::make_unique<Result>();
    CGAL::make_surface_mesh(result->complex, surface, criteria, CGAL::Manifold_tag());
    return result;
}

Mesh to_mesh(const Result& result) {
    CGAL::Surface_mesh<Point> surface;
    CGAL::facets_in_complex_2_to_triangle_mesh(result.complex, surface);
    Mesh mesh;
    for (const auto v : surface.vertices()) {
        const Point p = surface.point(v);
        mesh.points.push_back({p.x(), p.y(), p.z()});
    }
    for (const auto f : surface.faces()) {
        std::array<std::uint32_t, 3> corners{};
        std::size_t i = 0;
        for (const auto v : surface.vertices_around_face(surface.halfedge(f))) corners[i++] = v.idx();
        mesh.triangles.push_back(corners);
    }
    return mesh;
}

}  // namespace

int main() { serve(solve, to_mesh); }
