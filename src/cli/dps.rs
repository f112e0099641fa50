//! `hertzchain dps integrals`, `dps homoclinic` and `dps dark`.

use super::{
    Exit,
    args::{DarkArgs, HomoclinicArgs, IntegralsArgs},
    print,
};
use crate::{
    chain::Params,
    dps::{Averages, DarkProfile, Homoclinic},
    output::Folder,
    report,
};
use std::process::ExitCode;

pub(super) fn homoclinic(args: &HomoclinicArgs) -> Exit {
    let one = Homoclinic::new(args.alpha, args.center)?;
    print(&if args.json { report::homoclinic_json(&one) + "\n" } else { report::homoclinic_table(&one) });
    Ok(ExitCode::SUCCESS)
}

pub(super) fn dark(args: &DarkArgs) -> Exit {
    let &DarkArgs { sites, alpha, kappa, rho, c, .. } = args;
    let profile = DarkProfile::new(Params { alpha, kappa, rho }, args.center, sites, c)?;
    let omega_b = args.omega_b.unwrap_or(1.005 * profile.params().omega());
    let json = report::dark_json(&profile, omega_b)?;
    let folder = args.out.as_ref().map(Folder::create).transpose()?;
    print(&if args.json { json.clone() + "\n" } else { report::dark_table(&profile, omega_b)? });
    if let Some(folder) = folder {
        folder.write("dark.csv", &report::dark_csv(&profile, omega_b)?)?;
        folder.write("dark.json", json.as_bytes())?;
        eprintln!("written to {}", folder.path().display());
    }
    Ok(ExitCode::SUCCESS)
}

pub(super) fn integrals(args: &IntegralsArgs) -> Exit {
    let (averages, point) = (Averages::new(args.alpha, args.kappa)?, (args.b, args.r));
    let values = averages.checked(args.b, args.r)?;
    let json = || report::averages_json(&averages, point, &values) + "\n";
    print(&if args.json { json() } else { report::averages_table(&values) });
    Ok(ExitCode::SUCCESS)
}
