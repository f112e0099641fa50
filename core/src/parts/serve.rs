//! The loop of all parts but part 0, which follow its orders.

use super::{Carrier, Division, Files, Own, order::Order, part::Part};
use crate::chain::Chain;
use std::collections::BTreeMap;

/// Integrates this part of chains by the orders of part 0, until part 0 orders the end. What this
/// part keeps is written by `files`.
///
/// # Panics
/// If part 0 ends without that order, or sends words that are no order.
pub fn serve(carrier: &mut dyn Carrier, files: &dyn Files) {
    let mut flows: BTreeMap<u64, Part> = BTreeMap::new();
    let mut kept: Option<(Own, Chain<f64>)> = None;
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
            Order::Keep(motion, chain) => {
                let division = Division::new(chain.topology(), carrier.parts(), motion);
                kept = Some((Own::new(chain.layout().resonators(), division, carrier.part()), *chain));
            }
            Order::Put => own(&mut kept).receive(carrier),
            Order::Show => own(&mut kept).send(carrier),
            Order::Take(flow) => own(&mut kept).take(of(&mut flows, flow)),
            Order::Give(flow) => {
                let (own, chain) = kept.as_ref().expect(KNOWN);
                own.give(of(&mut flows, flow), chain.topology(), carrier);
            }
            Order::Lose => own(&mut kept).lose(),
            Order::Piece(part, _) if part != carrier.part() => {}
            Order::Piece(_, sites) => carrier.send(0, &own(&mut kept).message(sites)),
            Order::Profile => own(&mut kept).keep(),
            Order::Write(leg, folder) => {
                let said = own(&mut kept).write(files, &folder, leg).err().unwrap_or_default();
                send_text(carrier, &said);
            }
            Order::End => return,
        }
    }
}

const KNOWN: &str = "orders are about flows that were begun";

fn of(flows: &mut BTreeMap<u64, Part>, flow: u64) -> &mut Part {
    flows.get_mut(&flow).expect(KNOWN)
}

fn own(kept: &mut Option<(Own, Chain<f64>)>) -> &mut Own {
    &mut kept.as_mut().expect(KNOWN).0
}

/// Sends a text to part 0: its length, then each byte as a number.
fn send_text(carrier: &mut dyn Carrier, text: &str) {
    let bytes: Vec<f64> = text.bytes().map(f64::from).collect();
    carrier.send(0, &[bytes.len() as f64]);
    carrier.send(0, &bytes);
}

/// Receives a text from another part, see [`send_text`].
pub(super) fn receive_text(carrier: &mut dyn Carrier, from: usize) -> String {
    let mut length = [0.0];
    carrier.receive(from, &mut length);
    let mut bytes = vec![0.0; length[0] as usize];
    carrier.receive(from, &mut bytes);
    String::from_utf8_lossy(&bytes.into_iter().map(|byte| byte as u8).collect::<Vec<_>>()).into_owned()
}

/// Ends all parts that serve part 0, whose carrier this is.
pub fn end(carrier: &mut dyn Carrier) {
    carrier.broadcast(&mut Order::End.words());
}
