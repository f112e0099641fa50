//! The integrators by name.

pub use crate::chain::Split;
use crate::{
    chain::Chain,
    error::{Error, Result, require},
    parts,
};
use hertzchain_integrators::{
    Scheme, Tolerance,
    splitting::{self, tables},
};
use serde::{Deserialize, Serialize, Serializer};

/// A method with a name for the command line and scene files.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// A splitting scheme on one of the two splits.
    Splitting(&'static Scheme, Split),
    /// One kick a step, a processor before and after, and corrections at contacts that begin or
    /// end.
    Corrected(splitting::Parts),
    /// The discrete gradient: order two, conserves the energy exactly.
    Conserving,
    /// DOP853, the adaptive 8(5,3) pair.
    Dop853(Contacts),
    /// Contact collocation: adaptive; the ends of contacts are ends of panels.
    Collocation,
}

/// How DOP853 treats contacts that begin or end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contacts {
    /// No treatment: the error control shortens the steps that cross them.
    Crossed,
    /// The integration stops at each of them and starts again.
    Landed,
    /// As `Landed`, in a variable in which the solution is smooth at the contact.
    Regularised,
}

const ADAPTIVE: [Contacts; 3] = [Contacts::Crossed, Contacts::Landed, Contacts::Regularised];

/// What is known of a method.
#[derive(Clone, Debug, PartialEq)]
pub struct MethodInfo {
    /// Name on the command line and in scenes.
    pub name: String,
    /// Name of the family, for tables and colours.
    pub family: &'static str,
    /// Order on smooth problems.
    pub order: u32,
    /// Evaluations of the force a step.
    pub stages: usize,
    /// Article with the coefficients.
    pub source: &'static str,
    /// The tolerances that it accepts; `None` if it takes none.
    pub tolerance: Option<Tolerance>,
}

const PROCESSED: &str = "processed, one kick a step";

/// Number of steps, tolerance or windows of a method.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Setting {
    /// Number of equal steps over the whole span.
    Steps(u64),
    /// Tolerance. For DOP853: of a step, relative, and absolute in units of the size of the
    /// motion. For collocation: of the sum of the errors of all windows, relative to the
    /// size of the state. For contact-corrected splitting: of the state at the end.
    Tolerance(f64),
    /// Number of equal windows over the whole span, and number of Gauss nodes per panel.
    Windows(u64, usize),
}

/// Largest number of steps. At 10^7 steps a second they take three years.
const MOST_STEPS: f64 = 1e15;

impl Setting {
    /// `count` equal steps, rounded up. A count that exceeds a whole number by a relative 10^-12 or
    /// less is rounded down to it.
    ///
    /// # Errors
    /// More than 10^15, or a count that is not a number.
    pub fn steps(count: f64) -> Result<Self> {
        let steps = (count * (1.0 - 1e-12)).ceil();
        require(steps <= MOST_STEPS, "steps", steps, "at most 1e15 steps")?;
        Ok(Self::Steps(steps.max(1.0) as u64))
    }

    /// The setting for a leg that is the given share of the span. Its steps are no longer than
    /// those of the whole run; tolerances of the whole run are shared out in proportion.
    pub fn of_leg(self, method: Method, share: f64) -> Self {
        // A step that fits up to rounding is not split.
        let part = |count: u64| (count as f64 * share * (1.0 - 1e-12)).ceil().max(1.0) as u64;
        match self {
            Self::Steps(steps) => Self::Steps(part(steps)),
            Self::Windows(windows, nodes) => Self::Windows(part(windows), nodes),
            // At least the smallest tolerance of the method, unless the given tolerance is smaller
            // still, and refused.
            Self::Tolerance(tol) if method.tolerance_is_global() => {
                Self::Tolerance((tol * share).max(tol.min(method.tolerances().least)))
            }
            Self::Tolerance(_) => self,
        }
    }
}

/// The names of [`Method::default_comparison_set`].
const DEFAULT_COMPARISON_SET: [&str; 11] = [
    "verlet",
    "yoshida4",
    "aba864",
    "srkn14-6",
    "strang-linear",
    "aba1064-linear",
    "corrected",
    "takahashi-imada-linear",
    "dop853",
    "dop853-regularised",
    "collocation",
];

/// Rule in the error for a tolerance given to a method that takes none.
pub const NO_TOLERANCE: &str = "a method with equal steps takes --step or --steps-per-period";

/// Most threads. Chosen: more than any machine has cores for.
const MOST_THREADS: usize = 1024;
/// Rule in the error for threads asked of a method that runs on one.
const ONE_THREAD: &str = "only splitting schemes and collocation run on several threads, as --integrator \
                          strang-linear: leave --threads out, or take one";

/// As its name.
impl Serialize for Method {
    fn serialize<S: Serializer>(&self, to: S) -> std::result::Result<S::Ok, S::Error> {
        to.serialize_str(&self.name())
    }
}

impl Method {
    /// Contact-corrected splitting on the exact linear flow.
    pub const CORRECTED: Self = Self::Corrected(splitting::Parts::ALL);
    /// The processed kernel of Takahashi and Imada on the exact linear flow, without corrections at
    /// contacts.
    pub const TAKAHASHI_IMADA: Self = Self::Corrected(splitting::Parts::PROCESSED);

    /// All methods: kinetic splits, linear splits, the processed ones, the one that conserves the
    /// energy, the adaptive ones, then collocation.
    pub fn all() -> Vec<Self> {
        let on = |split| tables::ALL.iter().map(move |scheme| Self::Splitting(scheme, split));
        let processed = [Self::CORRECTED, Self::TAKAHASHI_IMADA];
        on(Split::Kinetic)
            .chain(on(Split::Linear))
            .chain(processed)
            .chain([Self::Conserving])
            .chain(ADAPTIVE.map(Self::Dop853))
            .chain([Self::Collocation])
            .collect()
    }

    /// The default methods of a comparison: those that are the fastest at some error on a built-in
    /// scene, one of each group of similar schemes, and two references (`verlet`, `dop853`).
    pub fn default_comparison_set() -> Vec<Self> {
        Self::all().into_iter().filter(|method| DEFAULT_COMPARISON_SET.contains(&method.name().as_str())).collect()
    }

    /// The method with the given name.
    ///
    /// # Errors
    /// An unknown name; the message gives the most similar known one.
    pub fn named(name: &str) -> Result<Self> {
        let all = Self::all();
        let names: Vec<String> = all.iter().map(Self::name).collect();
        match names.iter().position(|known| known == name) {
            Some(i) => Ok(all[i]),
            None => Err(Error::unknown("integrator", name, names.iter().map(String::as_str))),
        }
    }

    /// What is known of the method, told once.
    pub fn info(&self) -> MethodInfo {
        let of = |scheme: &'static Scheme, name: String, family| MethodInfo {
            name,
            family,
            order: scheme.order,
            stages: scheme.stages(),
            source: scheme.source,
            tolerance: None,
        };
        let one = |name: &str, family, (order, stages), source, tolerance| MethodInfo {
            name: name.to_owned(),
            family,
            order,
            stages,
            source,
            tolerance,
        };
        match self {
            Self::Splitting(scheme, Split::Kinetic) => {
                let name = if scheme.name == tables::STRANG.name { "verlet" } else { scheme.name };
                of(scheme, name.to_owned(), "kinetic + potential")
            }
            Self::Splitting(scheme, Split::Linear) => {
                of(scheme, format!("{}-linear", scheme.name), "exact linear flow + contact kick")
            }
            Self::Corrected(splitting::Parts { corrected: false, .. }) => {
                let source = "Takahashi & Imada 1984, J. Phys. Soc. Jpn. 53, 3765; processed after Rowlands 1991, J. Comput. Phys. 97, 235";
                one("takahashi-imada-linear", PROCESSED, (4, 1), source, None)
            }
            Self::Corrected(_) => {
                let source = "this software; Takahashi & Imada 1984; Navot 1961, J. Math. and Phys. 40, 271";
                one("corrected", PROCESSED, (4, 1), source, Some(Tolerance::CORRECTED))
            }
            // The discrete gradient iterates: five to ten evaluations where steps resolve contacts.
            Self::Conserving => {
                let source = "McLachlan, Quispel & Robidoux 1999, Phil. Trans. R. Soc. A 357, 1021";
                one("discrete-gradient", "energy-conserving", (2, 1), source, None)
            }
            Self::Dop853(contacts) => {
                let (name, tolerance) = match contacts {
                    Contacts::Crossed => ("dop853", Tolerance::CROSSED),
                    Contacts::Landed => ("dop853-landed", Tolerance::RUN),
                    Contacts::Regularised => ("dop853-regularised", Tolerance::RUN),
                };
                let source = "Dormand & Prince 1980; Hairer, Norsett & Wanner 1993, Sec. II.5, II.10";
                one(name, "adaptive", (8, 12), source, Some(tolerance))
            }
            // Order: twice the number of Gauss nodes a panel, 8 at the middle of the range.
            Self::Collocation => {
                let source = "this software; Gauss collocation after Hairer, Lubich & Wanner 2006, Sec. II.1";
                one("collocation", "contact collocation", (16, 8), source, Some(Tolerance::RUN))
            }
        }
    }

    /// Name of the method: that of the scheme, with `-linear` on the exact linear flow; `verlet`
    /// for Strang's scheme on the kinetic split.
    pub fn name(&self) -> String {
        self.info().name
    }

    /// Whether the method chooses its steps during the run, by a tolerance.
    pub fn adaptive(&self) -> bool {
        matches!(self, Self::Dop853(_) | Self::Collocation)
    }

    /// Whether the method accepts a tolerance.
    pub fn tolerant(&self) -> bool {
        self.info().tolerance.is_some()
    }

    /// Refuses a number of threads on which the method does not move a chain.
    ///
    /// # Errors
    /// A number outside 1 to 1024; several threads, but for splitting schemes and collocation; for
    /// splitting schemes, what [`divides`](parts::divides) refuses.
    pub fn takes(&self, threads: Option<usize>, chain: &Chain<f64>) -> Result<()> {
        let count = threads.unwrap_or(1);
        require((1..=MOST_THREADS).contains(&count), "threads", count, "from 1 to 1024 threads")?;
        match self {
            Self::Collocation => Ok(()),
            Self::Splitting(..) => parts::divides(chain, count),
            _ if count == 1 => Ok(()),
            _ => Err(Error::parameter("integrator", self.name(), ONE_THREAD)),
        }
    }

    /// Whether its tolerance holds for the whole run, not for a step.
    pub fn tolerance_is_global(&self) -> bool {
        self.tolerant() && !matches!(self, Self::Dop853(_))
    }

    /// The tolerances that the method accepts, if it takes one.
    pub fn tolerances(&self) -> Tolerance {
        self.info().tolerance.unwrap_or(Tolerance::RUN)
    }

    /// Refuses a chain that the method cannot run. Those that can run one with
    /// [`Details`](crate::chain::Details) are DOP853, collocation unless the chain is [beyond
    /// it](Chain::beyond_collocation), splittings unless contacts dissipate, and contact-corrected
    /// ones where energy is conserved, all contacts have one exponent, and nothing else holds
    /// beads.
    ///
    /// # Errors
    /// A chain that the method cannot run; the message names a method that can.
    pub fn runs(&self, chain: &Chain<f64>) -> Result<()> {
        let refused = |reason| Err(Error::parameter("integrator", self.name(), reason));
        self.unsupported_reason(chain).map_or(Ok(()), refused)
    }

    /// Why the method cannot run a chain, and a method that can; `None` if it can.
    pub fn unsupported_reason(&self, chain: &Chain<f64>) -> Option<&'static str> {
        chain.details()?;
        match self {
            Self::Dop853(_) => None,
            Self::Collocation => chain.beyond_collocation(),
            Self::Splitting(..) => chain
                .dissipative_contacts()
                .then_some("its kicks know no velocities, and contacts here dissipate: take dop853-regularised"),
            Self::Corrected(..) if chain.parts()?.corrects() => None,
            Self::Corrected(..) | Self::Conserving if chain.dissipative_contacts() => {
                Some("it needs contacts that do not dissipate: take dop853-regularised")
            }
            Self::Corrected(..) => Some(
                "it needs contacts of one exponent, without damping, moved beads, forces that change, on-site \
                 springs, or springs and magnets between beads: take dop853-regularised, or strang-linear for \
                 equal steps",
            ),
            Self::Conserving => Some(
                "it needs equal beads and contacts of one power, without damping or drives: take dop853-regularised, \
                 or strang-linear for equal steps",
            ),
        }
    }

    /// The method for a given tolerance, where none is named.
    pub fn by_tolerance(chain: &Chain<f64>) -> Self {
        if Self::Collocation.runs(chain).is_ok() { Self::Collocation } else { Self::Dop853(Contacts::Regularised) }
    }

    /// The method for equal steps, where none is named.
    pub fn by_steps(chain: &Chain<f64>) -> Self {
        match Self::CORRECTED.unsupported_reason(chain) {
            None => Self::CORRECTED,
            Some(_) => Self::Splitting(&tables::STRANG, Split::Linear),
        }
    }

    /// The split of a method with equal steps whose steps do not end at contacts.
    pub fn split(&self) -> Option<Split> {
        match *self {
            Self::Splitting(_, split) => Some(split),
            Self::Corrected(_) => Some(Split::Linear),
            _ => None,
        }
    }
}
