use contact_patch::{gap::*, *};
fn main() {
    let p = Polyhedron::pyramid(3, 45f64.to_radians()).unwrap();
    for n in [25, 49, 75, 101] {
        for k in [Kernel::Collocation, Kernel::Galerkin] {
            probe(&p, 1.0, n, k);
        }
    }
    let p = Polyhedron::pyramid(4, 45f64.to_radians()).unwrap();
    for n in [49, 101] {
        for k in [Kernel::Collocation, Kernel::Galerkin] {
            probe(&p, 1.0, n, k);
        }
    }
    let p = Paraboloid::new([1.0, 1.0]).unwrap();
    for n in [49] {
        for k in [Kernel::Collocation, Kernel::Galerkin] {
            probe(&p, 1.0, n, k);
        }
    }
    let p = Paraboloid::new([1.0, 3000.0]).unwrap();
    for n in [49] {
        for k in [Kernel::Collocation, Kernel::Galerkin] {
            probe(&p, 1.0, n, k);
        }
    }
}
