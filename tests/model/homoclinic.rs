//! Homoclinic solutions of the stationary DpS equation against shooting with 1000 digits, and
//! against the theory.

use hertzchain::dps::{Center, Homoclinic};

const BOTH: [Center; 2] = [Center::Site, Center::Bond];

#[test]
fn values_are_those_of_shooting_with_1000_digits() {
    // tests/reference/homoclinic.py uses bisection and the map; this library uses iteration and
    // Newton's method.
    let table = include_str!("../reference/homoclinic.csv");
    let mut worst = 0.0f64;
    let mut rows = 0;
    for (alpha, center) in [
        (1.5, "site"),
        (1.5, "bond"),
        (2.5, "site"),
        (2.5, "bond"),
        (5.0, "site"),
        (5.0, "bond"),
        (10.0, "site"),
        (10.0, "bond"),
    ] {
        let one = Homoclinic::new(alpha, if center == "site" { Center::Site } else { Center::Bond }).unwrap();
        let mut last = 0;
        for row in table.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>()) {
            if row[0].parse::<f64>().unwrap() != alpha || row[1] != center {
                continue;
            }
            last = row[2].parse().unwrap();
            let b: f64 = row[3].parse().unwrap();
            worst = worst.max((one.a(last).abs() / b - 1.0).abs());
            rows += 1;
        }
        // Neither more nor fewer sites.
        assert_eq!(last, *one.sites().end(), "{alpha} {center}");
    }
    println!("{rows} rows: {worst:e}");
    // Measured: every value is the nearest double.
    assert!(rows > 40 && worst == 0.0, "{rows} rows: {worst:e}");
}

#[test]
fn they_are_what_the_theorem_says() {
    for alpha in [1.01, 1.05, 1.2, 1.5, 2.0, 3.0, 7.0, 10.0] {
        for center in BOTH {
            let one = Homoclinic::new(alpha, center).unwrap();
            let (first, last) = one.sites().into_inner();
            for n in first..=last {
                let mirror = match center {
                    Center::Site => one.a(-n),
                    Center::Bond => -one.a(1 - n),
                };
                assert_eq!(one.a(n), mirror);
                assert!(one.a(n) * if n % 2 == 0 { 1.0 } else { -1.0 } > 0.0);
                assert!(n > 0 || one.a(n).abs() > one.a(n - 1).abs());
            }
            assert_eq!((one.a(last + 1), one.a(i64::MAX), one.a(i64::MIN)), (0.0, 0.0, 0.0));
            // The next value would be below the smallest normal double.
            assert!(one.a(last).abs().ln() * alpha < f64::MIN_POSITIVE.ln());
            // b_{n+1} = (b_n + b_{n+1})^alpha (1 + ..): the ratio of logarithms is alpha up to
            // b_{n+1}/b_n.
            let ratio = one.a(last).abs().ln() / one.a(last - 1).abs().ln();
            assert!((ratio / alpha - 1.0).abs() < 1e-5, "{alpha} {center:?}: {ratio}");
            println!(
                "{alpha} {center:?}: {} sites, residual {:e}, ratio {:e}",
                last - first + 1,
                one.residual(),
                ratio / alpha - 1.0
            );
            assert!(one.residual() < 3.2e-15, "{alpha} {center:?}: {:e}", one.residual());
        }
    }
}

#[test]
fn the_two_of_one_exponent_are_nearly_degenerate() {
    // Their l_2 norms differ by 7e-7 at alpha = 3/2.
    let [site, bond] = BOTH.map(|center| {
        let one = Homoclinic::new(1.5, center).unwrap();
        one.sites().map(|n| one.a(n).powi(2)).sum::<f64>().sqrt()
    });
    println!("{:e}", site / bond - 1.0);
    assert!(((site / bond - 1.0).abs() / 7e-7 - 1.0).abs() < 0.1);
}
