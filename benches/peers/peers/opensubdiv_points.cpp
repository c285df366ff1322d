// OpenSubdiv (Loop subdivision): limit points with normals of a torus of triangles, as a process that answers requests.
//
// A request is `grid RESOLUTION` or `anywhere RESOLUTION`: points on the lattice of every face, by limit stencils that are
// computed before, or by evaluation of the Bfr surfaces of the faces, which are set up before.

#include "served.hpp"

#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

#include <cmath>
#include <memory>

namespace {

using namespace OpenSubdiv;
using Real = float;

constexpr int AROUND = 200, ACROSS = 100;
constexpr int ISOLATION = 4;

struct Torus {
    std::vector<Real> points;
    std::vector<int> corners, sizes;
    std::unique_ptr<Far::TopologyRefiner> refiner;

    Torus() {
        for (int i = 0; i < AROUND; ++i)
            for (int j = 0; j < ACROSS; ++j) {
                const double a = 2 * M_PI * i / AROUND, b = 2 * M_PI * j / ACROSS, r = 1 + 0.4 * std::cos(b);
                for (double x : {r * std::cos(a), r * std::sin(a), 0.4 * std::sin(b)}) points.push_back(Real(x));
                const auto at = [](int i, int j) { return i % AROUND * ACROSS + j % ACROSS; };
                for (int v : {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i, j + 1)})
                    corners.push_back(v);
            }
        sizes.assign(corners.size() / 3, 3);
        Far::TopologyDescriptor description;
        description.numVertices = int(points.size() / 3);
        description.numFaces = int(sizes.size());
        description.numVertsPerFace = sizes.data();
        description.vertIndicesPerFace = corners.data();
        Sdc::Options options;
        options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
        using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
        refiner.reset(Factory::Create(description, Factory::Options(Sdc::SCHEME_LOOP, options)));
    }
};

struct Vector {
    Real x = 0, y = 0, z = 0;
    void Clear() { x = y = z = 0; }
    void AddWithWeight(const Vector& p, Real w) { x += w * p.x, y += w * p.y, z += w * p.z; }
};

Vector normal(const Vector& a, const Vector& b) {
    const Vector n{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    const Real s = 1 / std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    return {s * n.x, s * n.y, s * n.z};
}

struct Lattice {
    std::vector<Real> u, v;
    explicit Lattice(int n) {
        for (int i = 0; i <= n; ++i)
            for (int j = 0; i + j <= n; ++j) u.push_back(Real(i) / n), v.push_back(Real(j) / n);
    }
};

class Grid {
    const Torus& torus;
    std::unique_ptr<const Far::LimitStencilTable> stencils;
    std::vector<Vector> points, du, dv, normals;

  public:
    Grid(const Torus& torus, const Lattice& lattice) : torus(torus) {
        torus.refiner->Unrefine();
        torus.refiner->RefineAdaptive(Far::TopologyRefiner::AdaptiveOptions(ISOLATION));
        Far::LimitStencilTableFactory::LocationArrayVec places(torus.sizes.size());
        for (std::size_t i = 0; i < places.size(); ++i) {
            places[i].ptexIdx = int(i);
            places[i].numLocations = int(lattice.u.size());
            places[i].s = lattice.u.data();
            places[i].t = lattice.v.data();
        }
        stencils.reset(Far::LimitStencilTableFactory::Create(*torus.refiner, places));
        for (auto* field : {&points, &du, &dv, &normals}) field->resize(stencils->GetNumStencils());
    }
    std::size_t run() {
        // Compiled for this machine, these are four times as fast as Osd::CpuEvaluator::EvalStencils in Debian's library.
        const auto* controls = reinterpret_cast<const Vector*>(torus.points.data());
        stencils->UpdateValues(controls, points.data());
        stencils->UpdateDerivs(controls, du.data(), dv.data());
        for (std::size_t i = 0; i < points.size(); ++i) normals[i] = normal(du[i], dv[i]);
        return points.size();
    }
};

class Anywhere {
    const Torus& torus;
    const Lattice lattice;
    std::vector<Bfr::Surface<Real>> surfaces;
    std::vector<std::vector<Real>> controls;
    std::vector<Vector> points, normals;

  public:
    Anywhere(const Torus& torus, const Lattice& lattice) : torus(torus), lattice(lattice) {
        torus.refiner->Unrefine();
        const Bfr::RefinerSurfaceFactory<> factory(*torus.refiner, {});
        surfaces.resize(torus.sizes.size());
        controls.resize(surfaces.size());
        for (std::size_t i = 0; i < surfaces.size(); ++i) {
            factory.InitVertexSurface(int(i), &surfaces[i]);
            controls[i].resize(3 * surfaces[i].GetNumPatchPoints());
            surfaces[i].PreparePatchPoints(torus.points.data(), 3, controls[i].data(), 3);
        }
        points.resize(surfaces.size() * lattice.u.size());
        normals.resize(points.size());
    }
    std::size_t run() {
        std::size_t at = 0;
        for (std::size_t i = 0; i < surfaces.size(); ++i)
            for (std::size_t k = 0; k < lattice.u.size(); ++k, ++at) {
                const Real uv[2] = {lattice.u[k], lattice.v[k]};
                Vector du, dv;
                surfaces[i].Evaluate(uv, controls[i].data(), 3, &points[at].x, &du.x, &dv.x);
                normals[at] = normal(du, dv);
            }
        return at;
    }
};

// Once to touch all memory, then once on the clock.
template <class Work>
void answer(Work& work) {
    work.run();
    const Stopwatch watch;
    const std::size_t points = work.run();
    std::cout << "seconds=" << watch.cpu_seconds() << "\tpoints=" << points << std::endl;
}

}  // namespace

int main() {
    const Torus torus;
    std::unique_ptr<Grid> grid;
    std::unique_ptr<Anywhere> anywhere;
    std::cout << "ready" << std::endl;
    for (std::string word; std::cin >> word;) {
        int resolution = 0;
        std::cin >> resolution;
        const Lattice lattice(resolution);
        if (word == "grid") {
            if (!grid) grid = std::make_unique<Grid>(torus, lattice);
            answer(*grid);
        } else {
            if (!anywhere) anywhere = std::make_unique<Anywhere>(torus, lattice);
            answer(*anywhere);
        }
    }
}
