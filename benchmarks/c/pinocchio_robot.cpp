// Pinocchio's own algorithms, from its headers, on a robot in numbers: processor seconds of calls.
//     pinocchio_robot CALLS < ROBOT  ->  "aba SECONDS" and "crba SECONDS"
// A line for each joint: parent (0 is the ground), axis (0 x, 1 y, 2 z), rotation row by row and position
// of its frame in the parent's, then its body's mass, centre of mass and inertia about it, row by row.
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/multibody.hpp>
#include <string>

using namespace pinocchio;

static Eigen::Vector3d vector() {
    Eigen::Vector3d read;
    for (int k = 0; k < 3; k++) std::cin >> read[k];
    return read;
}

static Eigen::Matrix3d matrix() {
    Eigen::Matrix3d read;
    for (int k = 0; k < 3; k++) read.row(k) = vector();
    return read;
}

static Model robot() {
    Model model;
    int parent, axis;
    while (std::cin >> parent >> axis) {
        const Eigen::Matrix3d rotation = matrix();
        const SE3 placement(rotation, vector());
        const std::string name = "joint " + std::to_string(model.njoints);
        const JointIndex joint =
            axis == 0   ? model.addJoint(parent, JointModelRX(), placement, name)
            : axis == 1 ? model.addJoint(parent, JointModelRY(), placement, name)
                        : model.addJoint(parent, JointModelRZ(), placement, name);
        double mass;
        std::cin >> mass;
        const Eigen::Vector3d com = vector();
        model.appendBodyToJoint(joint, Inertia(mass, com, matrix()), SE3::Identity());
    }
    return model;
}

int main(int, char **arguments) {
    const Model model = robot();
    Data data(model);
    Eigen::VectorXd q = Eigen::VectorXd::Random(model.nq);
    const Eigen::VectorXd v = Eigen::VectorXd::Random(model.nv), torque = v;
    const long calls = std::atol(arguments[1]);
    const auto timed = [&](const char *name, auto call) {
        for (int turn = 0; turn < 2; turn++) { // the first warms up
            const std::clock_t begin = std::clock();
            for (long k = 0; k < calls; k++) {
                call();
                q[0] += 1e-9; // so that no call is the one before
            }
            const double took = double(std::clock() - begin) / CLOCKS_PER_SEC;
            if (turn) std::cout << name << " " << took << "\n";
        }
    };
    timed("aba", [&] { aba(model, data, q, v, torque); });
    timed("crba", [&] { crba(model, data, q, Convention::LOCAL); });
}
