// A peer in C++ as a process that answers requests; README.md has the protocol.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <ctime>
#include <exception>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

struct Request {
    std::string name, formula;
    std::array<double, 6> box;
    double parameter;
    std::string output;
};

struct Mesh {
    std::vector<std::array<double, 3>> points;
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

inline Request read_request(const std::string& line) {
    std::istringstream words(line);
    Request request;
    std::string box, parameter;
    std::getline(words, request.name, '\t');
    std::getline(words, request.formula, '\t');
    std::getline(words, box, '\t');
    std::getline(words, parameter, '\t');
    std::getline(words, request.output, '\t');
    std::istringstream numbers(box);
    for (double& x : request.box) numbers >> x;
    request.parameter = std::stod(parameter);
    return request;
}

// For the measuring program, as measure/src/shape.rs has it.
inline void write_mesh(const std::string& path, const Mesh& mesh) {
    std::ofstream out(path, std::ios::binary);
    const std::array<std::uint64_t, 2> counts{mesh.points.size(), mesh.triangles.size()};
    out.write("mesh....", 8);
    out.write(reinterpret_cast<const char*>(counts.data()), sizeof counts);
    out.write(reinterpret_cast<const char*>(mesh.points.data()), 24 * counts[0]);
    out.write(reinterpret_cast<const char*>(mesh.triangles.data()), 12 * counts[1]);
}

class Stopwatch {
    std::clock_t cpu = std::clock();
    std::chrono::steady_clock::time_point wall = std::chrono::steady_clock::now();

  public:
    double cpu_seconds() const { return double(std::clock() - cpu) / CLOCKS_PER_SEC; }
    double wall_seconds() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - wall).count();
    }
};

// `solve` is timed; `mesh` makes a Mesh of what it returns.
template <class Solve, class ToMesh>
void serve(Solve solve, ToMesh to_mesh) {
    std::cout << "ready" << std::endl;
    for (std::string line; std::getline(std::cin, line);) {
        try {
            const Request request = read_request(line);
            const Stopwatch watch;
            const auto result = solve(request);
            const double cpu = watch.cpu_seconds(), wall = watch.wall_seconds();
            const Mesh mesh = to_mesh(*result);
            if (request.output != "-") write_mesh(request.output, mesh);
            // Indices and single-precision coordinates.
            const std::size_t bytes = 12 * (mesh.points.size() + mesh.triangles.size());
            std::cout << "seconds=" << cpu << "\twall=" << wall << "\tbytes=" << bytes
                      << "\tfile=0\telements=" << mesh.triangles.size() << std::endl;
        } catch (const std::bad_alloc&) {
            std::cout << "error=out of memory" << std::endl;
        } catch (const std::exception& error) {
            std::string text = error.what();
            for (char& c : text) c = c == '\n' || c == '\t' ? ' ' : c;
            std::cout << "error=" << text << std::endl;
        }
    }
}
