//! The loop of all parts but part 0, which follow its orders.

use super::{Communicator, Division, order::Order, part::Part};
use std::collections::BTreeMap;

/// Integrates this part of chains by the orders of part 0, until part 0 orders the end.
///
/// # Panics
/// If part 0 ends without that order, or sends words that are no order.
pub fn serve(carrier: &mut dyn Communicator) {
    let mut flows: BTreeMap<u64, Part> = BTreeMap::new();
    let mut words = Vec::new();
    loop {
        carrier.broadcast(&mut words);
        let order = Order::of(&words).expect("part 0 sends orders");
        match order {
            Order::Begin(flow, motion, chain) => {
                let division = Division::new(chain.topology(), carrier.parts(), motion);
                flows.insert(flow, Part::new(&chain, division, (carrier.part(), carrier.threads()), motion));
            }
            Order::Load(flow) => of(&mut flows, flow).receive(carrier),
            Order::Store(flow) => of(&mut flows, flow).send(carrier),
            Order::Drift(flow, dt) => of(&mut flows, flow).drift(dt),
            Order::Kicks(flow, pairs) => of(&mut flows, flow).kick_drifts(&pairs, carrier),
            Order::Duplicate(from, to) => {
                let copy = of(&mut flows, from).duplicate();
                flows.insert(to, copy);
            }
            Order::Copy(from, to) => {
                let mut copy = flows.remove(&to).expect(KNOWN);
                copy.copy_from(of(&mut flows, from));
                flows.insert(to, copy);
            }
            Order::Forget(flow) => drop(flows.remove(&flow)),
            Order::Solve(flow, window) => {
                let verdict = of(&mut flows, flow).windows_mut().solve(&window, carrier);
                carrier.send(0, &verdict.numbers());
            }
            Order::Advance(flow) => of(&mut flows, flow).windows_mut().advance(),
            Order::Tell(flow) => of(&mut flows, flow).windows().send_pieces(carrier),
            Order::End => return,
        }
    }
}

const KNOWN: &str = "orders are about flows that were begun";

fn of(flows: &mut BTreeMap<u64, Part>, flow: u64) -> &mut Part {
    flows.get_mut(&flow).expect(KNOWN)
}

/// Ends all parts that serve part 0, whose carrier this is.
pub fn end(carrier: &mut dyn Communicator) {
    carrier.broadcast(&mut Order::End.words());
}
