//! No step allocates. A binary of its own, for its counting allocator.

use hertzchain::chain::{Boundary, Chain, CorrectedSplit, KineticFlow, LinearFlow, Params};
use hertzchain::integrators::{
    SplitFlow, Splitting, Stepper,
    collocation::StepControl,
    splitting::{Corrected, First, Parts, tables::ALL},
};
use hertzchain::scene::Scene;
use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
};

thread_local! {
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

/// The system's allocator, counting what the calling thread asks for.
struct Counting;

fn count() {
    // A thread that is being torn down has no counter any more, and nobody reads it.
    let _ = COUNT.try_with(|count| count.set(count.get() + 1));
}

// SAFETY: every call is handed to the system's allocator as it is.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller's promises are those that the system's allocator asks for.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: as above.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations(work: impl FnOnce()) -> u64 {
    let before = COUNT.get();
    work();
    COUNT.get() - before
}

fn assert_steps_allocate_nothing(chain: &Chain<f64>, mut flow: impl SplitFlow<f64>, name: &str) {
    let n = chain.sites();
    let mut y: Vec<f64> = (0..chain.layout().dim()).map(|i| 0.3 * ((i * i + n) as f64).sin()).collect();
    flow.load(&y);
    let flow_at_start = flow.duplicate();
    for scheme in ALL {
        let flow = flow_at_start.duplicate();
        let mut run = Splitting::new(scheme, First::Drift, flow, (0.0, 50.0), 1100).unwrap();
        let steps = allocations(|| (0..1000).for_each(|_| run.step().unwrap()));
        assert_eq!(steps, 0, "{name} {}", scheme.name);
        // The first look makes the copy that all looks share.
        let first = allocations(|| run.sample(run.time(), &mut y));
        assert!(first > 0);
        let looks = allocations(|| {
            (0..100).for_each(|_| {
                run.step().unwrap();
                run.sample(run.time() - 0.01, &mut y);
            });
        });
        assert_eq!(looks, 0, "{name} {}", scheme.name);
        assert!(y.iter().all(|value| value.is_finite()));
    }
}

#[test]
fn a_thousand_steps_allocate_nothing() {
    // Truth: a count of all calls of the allocator.
    assert_eq!(allocations(|| drop(vec![0_u8; 7])), 1, "the allocator counts");
    for rho in [0.0, 0.5, f64::INFINITY] {
        for boundary in [Boundary::Fixed, Boundary::StrainRing] {
            let chain = Chain::new(Params::new(1.5, 1.0, rho).unwrap(), boundary, 150).unwrap();
            assert_steps_allocate_nothing(&chain, KineticFlow::new(chain.clone()), "kinetic");
            assert_steps_allocate_nothing(&chain, LinearFlow::new(chain.clone()), "linear");
        }
    }
}

#[test]
fn corrected_steps_allocate_nothing() {
    // Truth: a count of all calls of the allocator. Contacts begin and end all the time.
    let scene = Scene::load("tw-q15").unwrap();
    let mut flow = LinearFlow::new(scene.chain().clone());
    flow.load(scene.initial().as_slice());
    let mut run = Corrected::new(CorrectedSplit::new(flow), (0.0, 100.0), 4000, Parts::ALL).unwrap();
    assert_eq!(allocations(|| (0..4000).for_each(|_| run.step().unwrap())), 0);
}

#[test]
fn windows_of_collocation_allocate_nothing() {
    // Truth: a count of all calls of the allocator. Each of 50 bonds has lists of contacts and
    // crossings, which grow when first used; nearly all have by 150 periods.
    let scene = Scene::load("tw-q15").unwrap();
    let (y0, period) = (scene.initial().as_slice(), scene.period());
    let equal = StepControl::Windows { windows: 12_000, nodes: 12, neighbours: true };
    for control in [equal, StepControl::Tolerance(1e-6), StepControl::Tolerance(1e-11)] {
        let mut run = scene.chain().collocation(y0, (0.0, 300.0 * period), control).unwrap();
        // The first window makes the memory of the solver.
        run.step().unwrap();
        let mut up_to = |periods: f64| {
            allocations(|| {
                while run.time() < periods * period && !run.done() {
                    run.step().unwrap();
                }
            })
        };
        let [grown, rest] = [150.0, 300.0].map(&mut up_to);
        println!("{control:?}: {grown} up to 150 periods, {rest} after");
        assert!(grown > 0 && grown < 50 * 10);
        // Five of 900 windows, at most.
        assert!(rest <= 10, "{control:?}: {rest}");
    }
}
