//! The bridge's links: where they lead, which are signed, whose orders count.

use std::net::IpAddr;
use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use helmlink_wire::signing::Unsigned;

use super::signing::SigningStore;
use crate::app::failure::Failure;
use crate::app::guarded::Guarded;
use crate::app::ranges::SystemId;
use crate::app::state_dir::StateDirArgs;
use crate::bridge::Bridge;
use crate::gate::{Gate, Terms};
use crate::link::{EndpointId, Hub, LinkSettings, LinkUrl};

/// Options about links other than the one to the flight controller, and about who is trusted on all of them.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Links")]
pub struct LinkArgs {
    /// A ground station (repeatable); the same forms as --connect
    #[arg(long, value_name = "URL")]
    pub gcs: Vec<LinkUrl>,
    /// Sign what is sent and require signatures: a file of 32 bytes, 64 hexadecimal digits or a passphrase
    #[arg(long, value_name = "FILE")]
    pub signing_key: Option<PathBuf>,
    /// The links that are signed
    #[arg(long, default_value = "all", value_name = "all|connect|gcs")]
    pub sign: SignedLinks,
    /// Accept unsigned frames on signed links too (RADIO_STATUS always is)
    #[arg(long)]
    pub accept_unsigned: bool,
    /// Take orders only from this system (repeatable); from everybody if not given
    #[arg(long, value_name = "ID")]
    pub allow_system: Vec<SystemId>,
}

/// Which links are signed, where there is a key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SignedLinks {
    /// Every link.
    All,
    /// The one to the flight controller.
    Connect,
    /// Those to ground stations.
    Gcs,
}

impl FromStr for SignedLinks {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "all" => Ok(Self::All),
            "connect" => Ok(Self::Connect),
            "gcs" => Ok(Self::Gcs),
            other => Err(format!("`{other}` is none of all, connect and gcs")),
        }
    }
}

impl LinkArgs {
    /// The key file, if there is one, is read, and the last time stamp.
    pub(super) fn signing(&self, state: &StateDirArgs) -> Result<Option<SigningStore>, Failure> {
        let Some(key) = &self.signing_key else {
            if self.accept_unsigned {
                return Err(Failure::usage("--accept-unsigned makes sense only with --signing-key FILE"));
            }
            return Ok(None);
        };
        SigningStore::open(key, &state.folder()?).map(Some)
    }

    /// Puts the bridge behind a gate and opens all links.
    pub(super) async fn open(
        &self,
        connect: &LinkUrl,
        bridge: Bridge,
        signing: Option<&SigningStore>,
    ) -> Result<(Guarded<Bridge>, Hub), Failure> {
        let mut hub = Hub::new(LinkSettings::default());
        let gate = Gate::new(
            signing.map(SigningStore::signing),
            self.allow_system.iter().map(|system| **system).collect(),
        );
        let mut guarded = Guarded::new(bridge, gate);
        for url in std::iter::once(connect).chain(&self.gcs) {
            let endpoint = hub.open(url).await.map_err(Failure::usage)?;
            let terms = self.terms(endpoint, signing.is_some());
            guarded.agree(endpoint, terms);
            match hub.local_address(endpoint).filter(|_| url.listens()) {
                Some(address) => {
                    tracing::info!("listening at {url} ({address})");
                    if !terms.signed && !is_private(address.ip()) {
                        tracing::warn!(
                            "everybody who reaches {address} can command the boat: use --signing-key, or listen at \
                             127.0.0.1"
                        );
                    }
                }
                None => tracing::info!("connecting to {url}"),
            }
        }
        Ok((guarded, hub))
    }

    fn terms(&self, endpoint: EndpointId, has_key: bool) -> Terms {
        let is_vehicle = endpoint == EndpointId::FIRST;
        let chosen = match self.sign {
            SignedLinks::All => true,
            SignedLinks::Connect => is_vehicle,
            SignedLinks::Gcs => !is_vehicle,
        };
        Terms {
            signed: has_key && chosen,
            unsigned: if self.accept_unsigned { Unsigned::Accepted } else { Unsigned::Refused },
            // More endpoints than that nobody has; numbers need not be different, only better so.
            number: endpoint.0 as u8,
        }
    }
}

/// Only programs on this machine reach the address.
fn is_private(address: IpAddr) -> bool {
    address.to_canonical().is_loopback()
}
