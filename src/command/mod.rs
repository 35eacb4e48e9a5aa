//! The subcommands, and what they share.

mod check;
mod export;
mod gallery;
mod health;
mod key;
mod progress;
mod render;
mod serve;
mod world;

pub(crate) use check::check;
pub(crate) use export::{ExportArguments, MergeArguments, export, merge};
pub(crate) use gallery::{GalleryArguments, gallery};
pub(crate) use health::{HealthArguments, health};
pub(crate) use key::{KeyCommand, key};
pub(crate) use render::{RenderArguments, render};
pub(crate) use serve::{ServeArguments, serve};
use world::{parse, world};

use anyhow::Context;
use clap::ValueEnum;
use std::{fs, path::Path};
use terrane::{geometry::Filter, server::Config, tile::Height};

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Drawn {
    Ground,
    Water,
}

#[derive(Clone, Copy, ValueEnum)]
enum Detail {
    Band,
    Exact,
}

impl Drawn {
    fn height(self) -> Height {
        match self {
            Drawn::Ground => Height::Ground,
            Drawn::Water => Height::Water,
        }
    }
}

impl Detail {
    fn filter(self) -> Filter {
        match self {
            Detail::Band => Filter::Band,
            Detail::Exact => Filter::Exact,
        }
    }
}

fn parse_bbox(text: &str) -> Result<[f64; 4], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    numbers.ok().and_then(|numbers| numbers.try_into().ok()).ok_or_else(|| "four numbers are needed: minx,miny,maxx,maxy".to_owned())
}

fn config(file: Option<&Path>) -> anyhow::Result<Config> {
    let text = match file {
        Some(file) => fs::read_to_string(file).with_context(|| format!("reading {}", file.display()))?,
        None => String::new(),
    };
    let environment = std::env::vars_os().filter_map(|(name, value)| Some((name.into_string().ok()?, value.into_string().ok()?)));
    Ok(Config::load(&text, environment)?)
}

fn runtime() -> anyhow::Result<tokio::runtime::Runtime> {
    tokio::runtime::Builder::new_multi_thread().enable_all().build().context("starting the runtime")
}
