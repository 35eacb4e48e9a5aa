use super::*;
use crate::genetic::Evolution;
use serde_json::Value;

fn search(change: impl FnOnce(&mut Value)) -> Vec<u8> {
    let mut work = json!({"evolution": {"seed": 5, "settings": {"population": 8, "islands": 2, "generations": 4, "migration": {"every": 2, "count": 1}},
        "aim": {"seed": 3, "samples": 16, "wanted": [{"weight": 2, "criterion": {"accessibility": {"slope": 15, "share": 0.8}}}, {"criterion": {"roughness": {"value": 0.1}}}]}}});
    change(&mut work["evolution"]);
    work.to_string().into_bytes()
}

fn parsed(change: impl FnOnce(&mut Value)) -> Result<Work, DocumentError> {
    let work = Work::parse(&search(change))?;
    work.check().map(|()| work)
}

/// All checkpoints of a work, going on from the state of each where `written` says so.
fn run(work: &Work, written: bool) -> Vec<Checkpoint> {
    let (mut course, mut all) = (work.begin(None).expect("right"), Vec::new());
    loop {
        match course.turn(&Stop::never(), &|_| {}).expect("goes on").expect("nobody stops it") {
            Turn::On(next, checkpoint) => {
                course = if written { work.begin(Some(&checkpoint.state)).expect("its own") } else { next };
                all.push(checkpoint);
            }
            Turn::Found(checkpoint) => {
                all.push(checkpoint);
                return all;
            }
            Turn::Raster(_) => panic!("no drawing"),
        }
    }
}

#[test]
fn an_evolution_goes_on_from_its_checkpoints_as_if_it_had_never_stopped() {
    let work = parsed(|_| {}).expect("right");
    let whole = run(&work, false);
    assert_eq!(whole.iter().map(|checkpoint| checkpoint.step).collect::<Vec<_>>(), [0, 1, 2, 3, 4]);
    assert_eq!(run(&work, true), whole);
    let Work::Evolution(search) = &work else { panic!("an evolution") };
    let mut evolution = Evolution::new(&search.aim, search.settings, search.seed, &Stop::never()).expect("right").expect("nobody stops it");
    evolution.run(&Stop::never(), &mut |_| true);
    let last: Stage = serde_json::from_slice(&whole[4].state).expect("written");
    assert_eq!((last.state(), last.progress()), (evolution.state(), whole[4].line));
    // The best is kept whether or not it lives on.
    assert!(whole.windows(2).all(|pair| pair[0].found.judgement.score <= pair[1].found.judgement.score));
}

#[test]
fn a_goal_ends_it_and_a_stop_leaves_nothing() {
    let work = parsed(|search| search["goal"] = json!(0.01)).expect("right");
    assert_eq!(run(&work, false).len(), 1);
    let stop = Stop::new();
    stop.set();
    assert!(work.begin(None).expect("right").turn(&stop, &|_| {}).expect("stopped").is_none());
}

#[test]
fn a_state_of_other_work_is_not_gone_on_from() {
    let states = run(&parsed(|_| {}).expect("right"), false);
    let other = parsed(|search| search["seed"] = json!(6)).expect("right");
    assert!(other.begin(Some(&states[2].state)).is_err() && other.begin(Some(b"{}")).is_err());
    let older = String::from_utf8(states[2].state.clone()).expect("JSON").replacen("\"form\":1", "\"form\":0", 1);
    assert!(parsed(|_| {}).expect("right").begin(Some(older.as_bytes())).is_err());
}

#[test]
fn what_is_left_out_is_completed_and_has_the_same_name() {
    let short =
        Work::parse(br#"{"evolution": {"aim": {"scale": null, "wanted": [{"criterion": {"roughness": {"value": 0.1}}}]}, "goal": null}}"#).expect("right");
    let whole = Work::parse(short.to_json().to_string().as_bytes()).expect("its own");
    assert_eq!((&whole, whole.id()), (&short, short.id()));
    assert_eq!(short.to_json()["evolution"]["settings"]["population"], 64);
    assert_eq!(short.to_json()["evolution"]["aim"]["wanted"][0]["weight"], 1);
}

#[test]
fn what_is_wrong_is_told_with_its_place() {
    type Change<'a> = &'a dyn Fn(&mut Value);
    let cases: [(Change, &str); 12] = [
        (&|search| search["aim"]["wanted"] = json!([]), "/evolution/aim/wanted: "),
        (&|search| search["aim"]["wanted"][0]["criterion"]["accessibility"]["share"] = json!(2), "/evolution/aim/wanted/0/criterion/accessibility/share: "),
        (&|search| search["aim"]["samples"] = json!("many"), "/evolution/aim/samples: "),
        (&|search| search["aim"]["colour"] = json!(1), "/evolution/aim/colour: "),
        (&|search| search["aim"] = json!([]), "/evolution/aim: "),
        (&|search| search["settings"]["elite"] = json!(9), "/evolution/settings/elite: "),
        (&|search| search["settings"]["generations"] = json!(10_001), "/evolution/settings/generations: must be at most 10000"),
        (&|search| search["settings"]["population"] = json!(20_000), "/evolution/settings/population: "),
        (&|search| search["seed"] = json!(1_u64 << 53), "/evolution/seed: "),
        (&|search| search["goal"] = json!(0), "/evolution/goal: "),
        (&|search| search["seeds"] = json!(0), "/evolution/seeds: unknown field `seeds`"),
        (
            &|search| (search["settings"]["generations"], search["aim"]["samples"]) = (json!(10_000), json!(1024)),
            "/evolution/settings/generations: all generations may take",
        ),
    ];
    for (change, expected) in cases {
        let told = parsed(change).expect_err(expected).to_string();
        assert!(told.starts_with(expected), "{told}");
    }
    assert!(Work::parse(b"{}").expect_err("neither").to_string().contains("`paths` or `evolution`"));
}
