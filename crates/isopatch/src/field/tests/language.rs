//! What the parser reads, and what it says about what it can't read.

use super::super::{ConstantError, Constants, Field, Formula, FormulaErrorKind};
use super::formula;
use crate::geom::Point3;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

const P: Point3 = Point3::new(0.75, -1.25, 2.5);

fn value(text: &str) -> f64 {
    formula(text).value(P)
}

#[test]
fn operators_bind_as_in_mathematics() {
    let (x, y, z) = (P.x, P.y, P.z);
    for (text, expected) in [
        ("-x^2", -(x * x)),
        ("2^-x^2", 2.0_f64.powf(-(x * x))),
        ("2^3^2", 512.0),
        ("x-y-z", x - y - z),
        ("12/3/2", 2.0),
        ("4xyz", 4.0 * x * y * z),
        ("2(x+1)(y-1)", 2.0 * (x + 1.0) * (y - 1.0)),
        ("x y", x * y),
        ("x(y+1)z", x * (y + 1.0) * z),
        ("2sin(x)", 2.0 * x.sin()),
        ("xsin(y)z", x * y.sin() * z),
        ("4 x^2y", 4.0 * x * x * y),
        ("1/2x", 0.5 * x),
        ("x = y + 1", x - (y + 1.0)),
        ("--x", x),
        ("+x*-y", -(x * y)),
        ("x**2·y×z − 1", x * x * y * z - 1.0),
        ("x²y³ + z¹⁰", x * x * (y * y * y) + z.powi(10)),
        ("2pi x", 2.0 * std::f64::consts::PI * x),
        ("3π", 3.0 * std::f64::consts::PI),
        ("1.5e2 + .5 + 2.e-1", 150.7),
        ("2exp(x)", 2.0 * x.exp()),
        ("y^(6/3)", y * y),
        ("x^-2", 1.0 / (x * x)),
        ("z^0.5", z.sqrt()),
        ("y^0 + 0^0", 2.0),
        ("min(x, y, z) + max(x, y)", y + x),
        ("ln(z) + log(z)", 2.0 * z.ln()),
        ("abs(y)sqrt(z)", -y * z.sqrt()),
    ] {
        let computed = value(text);
        assert!(
            (computed - expected).abs() <= 1e-12 * expected.abs().max(1.0),
            "{text}: {computed}, not {expected}"
        );
    }
}

#[test]
fn the_longest_known_name_wins() {
    let mut constants = Constants::new();
    for (name, value) in [("a", 2.0), ("ab", 3.0), ("xa", 5.0), ("r1", 7.0)] {
        constants.set(name, value).expect("a name");
    }
    for (text, expected) in
        [("a", 2.0), ("ab", 3.0), ("aab", 6.0), ("xab", 15.0 / 3.0 * f64::NAN), ("r1x", 7.0 * P.x)]
    {
        let parsed = Formula::parse(text, &constants);
        if expected.is_nan() {
            // xa is longer than x; what remains, b, is unknown.
            let error = parsed.expect_err("b is unknown");
            assert_eq!(error.column(), 1);
        } else {
            assert_eq!(parsed.expect("a formula").value(P), expected);
        }
    }
}

#[test]
fn errors_name_the_culprit_and_its_column() {
    for (text, column, message) in [
        ("", 1, "the formula is empty"),
        ("  ", 1, "the formula is empty"),
        ("x + foo", 5, "unknown name \"foo\"; --set foo=VALUE makes it a number"),
        ("4xyw", 4, "unknown name \"w\"; --set w=VALUE makes it a number"),
        ("x + sine(y)", 5, "unknown name \"sine\"; did you mean \"sin\"?"),
        ("sqr(x)", 1, "unknown name \"sqr\"; did you mean \"sqrt\"?"),
        ("X^2", 1, "unknown name \"X\"; did you mean \"x\"?"),
        ("x # y", 3, "unknown symbol '#'"),
        ("x²?", 3, "unknown symbol '?'"),
        ("x<1", 2, "unknown symbol '<': write =, the solid is where the left side is less"),
        ("(x+1", 1, "\"(\" without \")\""),
        ("x*(y+sin(z)", 3, "\"(\" without \")\""),
        ("sin(x", 4, "\"(\" without \")\""),
        // An equals sign inside is not to blame if the parenthesis was to end before it.
        ("(x^2+y^2 = 1", 1, "\"(\" without \")\""),
        ("x+sin(y+(z) = 1", 6, "\"(\" without \")\""),
        ("x = y = (z", 7, "\"=\" may stand only once, outside all parentheses"),
        ("x+1)", 4, "\")\" without \"(\""),
        ("x + * y", 5, "expected a number, a name or \"(\", found \"*\""),
        ("()", 2, "expected a number, a name or \"(\", found \")\""),
        ("x +", 4, "the formula ends where a number, a name or \"(\" should follow"),
        ("x2", 2, "a number can't follow here: write * or ^ before it"),
        ("2 3", 3, "a number can't follow here: write * or ^ before it"),
        ("sin x", 1, "sin needs its argument in parentheses"),
        ("min(x)", 1, "min takes two or more arguments, not 1"),
        ("x+sin(x,y)", 3, "sin takes one argument, not 2"),
        ("x, y", 2, "a comma may only separate the arguments of min and max"),
        ("min((x, y), z)", 7, "a comma may only separate the arguments of min and max"),
        ("x = y = z", 7, "\"=\" may stand only once, outside all parentheses"),
        ("(x = y)", 4, "\"=\" may stand only once, outside all parentheses"),
        ("x + 1e999", 5, "\"1e999\" is not a number, or too large or too small for one"),
        ("x + 1..2", 7, "a number can't follow here: write * or ^ before it"),
        ("x + .", 5, "\".\" is not a number, or too large or too small for one"),
    ] {
        let error = Formula::parse(text, &Constants::new()).expect_err(text);
        assert_eq!((error.column(), error.kind.to_string().as_str()), (column, message), "{text}");
    }
}

#[test]
fn messages_show_the_place() {
    let error = Formula::parse("x^2 + foo*y - 1", &Constants::new()).expect_err("foo");
    let what = "unknown name \"foo\"; --set foo=VALUE makes it a number";
    assert_eq!(error.to_string(), format!("column 7: {what}\n  x^2 + foo*y - 1\n        ^^^"));
    let long = format!("{} + ? + {}", "x+".repeat(100) + "x", "x+".repeat(100) + "x");
    let error = Formula::parse(&long, &Constants::new()).expect_err("?");
    let message = error.to_string();
    let lines: Vec<&str> = message.lines().collect();
    let caret = lines[2].chars().position(|c| c == '^').expect("a caret");
    assert_eq!(lines[1].chars().nth(caret), Some('?'));
    assert!(lines[1].chars().count() < 80 && lines[1].starts_with("  …") && lines[1].ends_with('…'));
}

#[test]
fn limits_are_errors_not_crashes() {
    let kind = |text: &str| Formula::parse(text, &Constants::new()).expect_err("too much").kind;
    let length = 100_000;
    assert_eq!(kind(&"x".repeat(length)), FormulaErrorKind::TooLong { length, limit: Formula::MAX_LENGTH });
    let nested = |n: usize| "(".repeat(n) + "x" + &")".repeat(n);
    assert_eq!(kind(&nested(10_000)), FormulaErrorKind::TooDeep { limit: Formula::MAX_NESTING });
    assert_eq!(kind(&"(".repeat(20_000)), FormulaErrorKind::TooDeep { limit: Formula::MAX_NESTING });
    assert_eq!(formula(&nested(Formula::MAX_NESTING)).value(P), P.x);
    assert_eq!(kind(&"x1".repeat(30_000)), FormulaErrorKind::NumberAfterOperand);
}

#[test]
fn long_formulas_within_the_limits_are_evaluated() {
    let terms = Formula::MAX_LENGTH / 2 - 1;
    assert_eq!(formula(&("-".repeat(2 * terms) + "x")).gradient(P).1.x, 1.0);
    assert_eq!(formula(&("x+".repeat(terms) + "x")).gradient(P).1.x, terms as f64 + 1.0);
    assert!(formula(&("2^".repeat(terms) + "2")).value(P).is_infinite());
    assert_eq!(formula(&("1^".repeat(terms) + "x")).jet(P).value, 1.0);
    let tower = formula(&("x^".repeat(terms) + "x"));
    assert!(tower.jet(P).value.is_finite() && tower.polynomial().is_none());
    let product = formula(&"x".repeat(2 * terms));
    assert!(product.value(P) >= 0.0 && product.polynomial().is_none());
    let thirds = terms / 2 - 1;
    let sum = formula(&("1/3+".repeat(thirds) + "x")).value(P);
    assert!((sum - thirds as f64 / 3.0 - P.x).abs() < 1e-9);
}

#[test]
fn constants_may_not_hide_names() {
    let mut constants = Constants::new();
    for name in ["x", "y", "z", "pi", "sin", "min", "ln"] {
        assert_eq!(constants.set(name, 1.0), Err(ConstantError::Reserved(name.to_owned())));
    }
    for name in ["", "1a", "a b", "a-b", "_"] {
        assert_eq!(constants.set(name, 1.0), Err(ConstantError::NotAName(name.to_owned())));
    }
    assert!(matches!(constants.set("a", f64::NAN), Err(ConstantError::NotANumber { .. })));
    assert!(matches!(constants.set("a", f64::INFINITY), Err(ConstantError::NotANumber { .. })));
    assert!(matches!(constants.assign("a=1x"), Err(ConstantError::NotANumber { .. })));
    assert!(matches!(constants.assign("a"), Err(ConstantError::NotAnAssignment(_))));
    constants.assign("a=-2.5").expect("fine");
    constants.assign("a=1e-2").expect("the later value counts");
    assert_eq!(constants.names().collect::<Vec<_>>(), ["a"]);
    assert_eq!(Formula::parse("xa", &constants).expect("a formula").value(P), P.x * 0.01);
}

/// Random formulas of the language.
fn formulas() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        Just("x".to_owned()),
        Just("y".to_owned()),
        Just("z".to_owned()),
        Just("pi".to_owned()),
        (0_u32..100).prop_map(|n| n.to_string()),
        (0.001_f64..100.0).prop_map(|v| v.to_string()),
    ];
    leaf.prop_recursive(6, 40, 3, |inner| {
        prop_oneof![
            (inner.clone(), inner.clone(), prop::sample::select(vec!["+", "-", "*", "/", " "]))
                .prop_map(|(a, b, op)| format!("({a}){op}({b})")),
            (inner.clone(), inner.clone(), prop::sample::select(vec!["+", "-"]))
                .prop_map(|(a, b, op)| format!("{a}{op}{b}")),
            (inner.clone(), -3_i32..6).prop_map(|(a, n)| format!("({a})^({n})")),
            (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("({a})^({b})")),
            inner.clone().prop_map(|a| format!("-({a})")),
            (inner.clone(), prop::sample::select(vec!["sqrt", "abs", "exp", "log", "sin", "atan", "tanh"]))
                .prop_map(|(a, f)| format!("{f}({a})")),
            (inner.clone(), inner.clone(), inner)
                .prop_map(|(a, b, c)| format!("min({a}, {b}, max({c}, {a}))")),
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, rng_seed: RngSeed::Fixed(20), ..ProptestConfig::default() })]

    #[test]
    fn any_text_gives_a_formula_or_a_message(text in "\\PC{0,60}") {
        if let Err(error) = Formula::parse(&text, &Constants::new()) {
            prop_assert!(!error.to_string().is_empty() && error.column() >= 1);
        }
    }

    #[test]
    fn any_mixture_of_tokens_gives_a_formula_or_a_message(
        words in prop::collection::vec(
            prop::sample::select(vec![
                "x", "y", "z", "2", "0.5", "+", "-", "*", "/", "^", "(", ")", ",", "=", "sin(", "min(", "pi", " ", "²",
            ]),
            0..30,
        )
    ) {
        match Formula::parse(&words.concat(), &Constants::new()) {
            Ok(formula) => {
                formula.jet(P);
                formula.rounding_bound(P);
                formula.polynomial();
                formula.kink_near(P, 1e-3);
                if !formula.value(P).is_finite() {
                    prop_assert!(formula.domain_error(P).is_some());
                }
            }
            Err(error) => prop_assert!(error.column() <= words.concat().chars().count() + 1),
        }
    }

    #[test]
    fn a_printed_formula_reads_as_itself(text in formulas()) {
        let first = formula(&text);
        let printed = first.to_string();
        let second = formula(&printed);
        prop_assert_eq!(second.to_string(), printed);
        prop_assert_eq!(first.value(P).to_bits(), second.value(P).to_bits());
    }

    #[test]
    fn random_formulas_keep_their_promises(text in formulas()) {
        let formula = formula(&text);
        let value = formula.value(P);
        let point = crate::geom::Aabb::new(P, P);
        let range = formula.range(&point);
        prop_assert!(range.lo <= range.hi);
        prop_assert_eq!(value.is_finite(), formula.domain_error(P).is_none());
        if value.is_finite() {
            prop_assert!(range.contains(value), "{} outside {:?}", value, range);
            let bound = formula.rounding_bound(P);
            if let Some(polynomial) = formula.polynomial() {
                let p = [P.x, P.y, P.z].map(|v| num_rational::BigRational::from_float(v).expect("finite"));
                let exact = num_traits::ToPrimitive::to_f64(&polynomial.value(&p)).expect("finite");
                prop_assert!((exact - value).abs() <= bound + exact.abs() * f64::EPSILON);
            }
        }
    }
}
