//! Keys of a server, made and taken back beside it.

use super::{config, runtime};
use anyhow::Context;
use clap::{Args, Subcommand};
use std::{
    io::Write,
    path::PathBuf,
    time::{SystemTime, UNIX_EPOCH},
};
use terrane::store::{KeyEntry, Scope, Store, sign};

#[derive(Subcommand)]
pub(crate) enum KeyCommand {
    /// Make a key and print it; it is kept nowhere
    New {
        /// Whose it is, for people
        name: String,
        /// What it is for: read, play (which reads too), write (which plays too) or admin (which does all)
        #[arg(long, default_value_t = Scope::Write)]
        scope: Scope,
        #[command(flatten)]
        folder: Folder,
    },
    /// Show all keys without their secrets
    List {
        #[command(flatten)]
        folder: Folder,
    },
    /// Print what an address is followed by to let a world be read without a key, where reads need one
    Sign {
        /// The id of the key in whose name, as `terrane key list` shows it
        id: String,
        /// What may be read: everything under /worlds/WORLD
        world: String,
        /// For how long from now
        #[arg(long, default_value_t = 24)]
        hours: u32,
        #[command(flatten)]
        folder: Folder,
    },
    /// Take a key back
    Revoke {
        /// Its id, as `terrane key list` shows it
        id: String,
        #[command(flatten)]
        folder: Folder,
    },
}

#[derive(Args)]
pub(crate) struct Folder {
    /// Folder of the server's data [default: ./data-store]
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
}

impl Folder {
    async fn open(self) -> anyhow::Result<Store> {
        let folder = self.data.map_or_else(|| config(None).map(|config| config.server.data), Ok)?;
        Ok(Store::open_beside(&folder).await?)
    }
}

pub(crate) fn key(command: KeyCommand) -> anyhow::Result<()> {
    let mut out = std::io::stdout();
    runtime()?.block_on(async {
        match command {
            KeyCommand::New { name, scope, folder } => {
                let (_, secret) = folder.open().await?.add_key(&name, scope).await?;
                Ok(writeln!(out, "{secret}")?)
            }
            KeyCommand::List { folder } => {
                for KeyEntry { id, name, scope, time, .. } in folder.open().await?.keys().await? {
                    writeln!(out, "{id}  {scope:<5}  {time}  {name}")?;
                }
                Ok(())
            }
            KeyCommand::Sign { id, world, hours, folder } => {
                let keys = folder.open().await?.keys().await?;
                let key = keys.iter().find(|key| key.id == id).with_context(|| format!("no key has the id {id:?}; `terrane key list` shows them"))?;
                let expires = SystemTime::now().duration_since(UNIX_EPOCH)?.as_secs() + u64::from(hours) * 3600;
                Ok(writeln!(out, "key={id}&expires={expires}&signature={}", sign(&key.hash, &world, expires))?)
            }
            KeyCommand::Revoke { id, folder } => Ok(folder.open().await?.revoke_key(&id).await?),
        }
    })
}
